#include "reports/check_report.hpp"

#include <algorithm>
#include <array>
#include <regex>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cells.hpp"
#include "pictures.hpp"

namespace takt::tool::check_report_test {
namespace {

using namespace cells;
using namespace drawings;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

std::string text(const model::Cell& cell, Style style = {}) { return check_text(cell, plans(cell), style); }

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream stream{text};
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

std::size_t widest(const std::string& text) {
  std::size_t most = 0;
  for (const auto& line : lines(text)) most = std::max(most, line.size());
  return most;
}

std::string long_name(char letter) { return std::string(63, letter); }

/// Returns a cell in which names, times, priorities, tables and lists are as long as possible, to test line
/// breaks.
model::Cell widest_cell() {
  const Nanoseconds odd{6'000'000'000'000'000'001};
  std::vector<model::Module> modules{process(periodic(long_name('p'), odd, -2'147'483'647)),
                                     with_budget(periodic(long_name('q'), odd), odd - 1ns),
                                     with_budget(process(sporadic(long_name('s'), odd, -2'147'483'647)), odd),
                                     process(non_real(long_name('n')))};
  for (auto& module : modules) {
    if (!module.executor.empty()) module.executor = long_name('e');
  }
  auto result = device(long_name('d'), modules, {long_name('e')});
  result.executors[0].cpu = 1023;
  const auto port = [](char letter) {
    return long_name('d') + "." + long_name(letter) + "." + long_name('o');
  };
  auto connection = on_topic(stale_after(queue(port('p'), port('q'), 65536), odd, model::Stale::error),
                             std::string(255, 't'));
  connection.lifespan = odd;
  connection.domain = 232;
  auto all = connected(cell(long_name('c'), {result}), {connection, on_topic(latest("", port('s')), "t")});
  all.discovery = {model::Discovery::Kind::server, {}, std::string(250, 'h') + ":65535", {}};
  all.server_device = long_name('d');
  return all;
}

// ---- Text

TEST(CheckText, ShowsThePapersFigure3WithEqualRowsOnOneLine) {
  EXPECT_THAT(text(figure1()), HasSubstr(R"(
    basic period 100 us, macro period 600 us, 6 rows, 15 entries

    row  offset  modules, in the order in which they run
    0    0 ns    control3, control2, controller1, control4 (process)
    1-2  100 us  control3, control2
    3    300 us  control3, control2, control4 (process)
    4-5  400 us  control3, control2
)"));
}

TEST(CheckText, DoesNotMergeRowsWithDifferentModules) {
  EXPECT_THAT(text(cell("c", {device("d", {periodic("a", 2ms), periodic("b", 3ms)})})),
              HasSubstr("    2    2 ms    a\n    3    3 ms    b\n    4    4 ms    a\n    5    5 ms    -\n"));
}

TEST(CheckText, ShowsThePapersFigure4WithDeadlines) {
  EXPECT_THAT(text(figure1()), HasSubstr(R"(
    sporadic   type     deadline  priority  budget
    emergency  thread   100 us    1         -
    vision     process  10 ms     2         -
)"));
}

TEST(CheckText, ShowsThatPeriodicProgramsHaveHigherPriorityThanSporadicModules) {
  EXPECT_THAT(text(figure1()), HasSubstr(R"(
    SCHED_FIFO  threads and process modules
    80          rows
    79          control4 (process)
    74          sporadic thread modules
    73          vision (process)
)"));
  EXPECT_THAT(text(cell("c", {device("d", {periodic("a", 1ms)})})), Not(HasSubstr("SCHED_FIFO")));
}

TEST(CheckText, ListsExecutorsAndNonRealTimeModules) {
  EXPECT_THAT(text(figure1()), AllOf(HasSubstr("cell module: 1 device, 7 modules"),
                                     HasSubstr("executor main: any cpu, priority 80, wakeup hybrid"),
                                     HasSubstr("not real-time: monitoring (process)")));
}

TEST(CheckText, ShowsAfterWhichTimeARunCountsAsHung) {
  model::Module patient = with_budget(periodic("b", 2ms), 200us);
  patient.hang = 50ms;
  model::Module program = process(with_budget(periodic("p", 1ms), 100us));
  EXPECT_THAT(text(cell("c", {device("d", {with_budget(periodic("a", 1ms), 300us), patient,
                                           with_budget(sporadic("s", 5ms), 3ms), program})})),
              HasSubstr("    a run hangs after: a 20 ms, b 50 ms, s 30 ms\n"));
  program.hang = 40ms;
  EXPECT_THAT(text(cell("c", {device("d", {program})})), HasSubstr("a run hangs after: p 40 ms\n"));
  EXPECT_THAT(text(cell("c", {device("d", {periodic("a", 1ms)})})), Not(HasSubstr("hangs")));
}

TEST(CheckText, PredictsTheLoadFromBudgets) {
  const std::string all = text(cell(
      "c", {device("d", {with_budget(periodic("a", 1ms), 300us), with_budget(periodic("b", 2ms), 200us)})}));
  EXPECT_THAT(all,
              AllOf(HasSubstr("row 0 is the fullest with 500 us of 1 ms (50 %); 40.0 % of the macro period"),
                    HasSubstr("0    0 ns    50 %  a, b\n"), HasSubstr("1    1 ms    30 %  a\n"),
                    Not(HasSubstr("without a budget"))));
}

TEST(CheckText, ShowsEachRowWithAndWithoutOffsets) {
  model::Cell shifted = figure1();
  shifted.devices[0].executors[0].offsets = model::Offsets::automatic;
  EXPECT_THAT(text(shifted),
              AllOf(HasSubstr("offsets: the fullest row has 3 modules; without offsets 4 modules\n"),
                    HasSubstr("shifted: controller1 by 100 us\n"),
                    HasSubstr("row  offset  modules  before  modules, in the order"),
                    HasSubstr("0    0 ns    3        4       control3, control2, control4 (process)\n"),
                    HasSubstr("1    100 us  3        2       control3, control2, controller1\n"),
                    HasSubstr("4-5  400 us  2        2       control3, control2\n")));
  EXPECT_THAT(text(figure1()), AllOf(Not(HasSubstr("before")), Not(HasSubstr("shifted"))));

  model::Cell full =
      cell("c", {device("d", {with_budget(periodic("a", 2ms), 900us), with_budget(periodic("b", 2ms), 600us),
                              with_budget(periodic("c", 1ms), 50us)})});
  full.devices[0].executors[0].offsets = model::Offsets::automatic;
  EXPECT_THAT(text(full),
              AllOf(HasSubstr("has 2 modules, 95 %; without offsets 3 modules, 155 %\n"),
                    HasSubstr("row  offset  load  before  modules"), HasSubstr("155 %"), HasSubstr("5 %")));
}

TEST(CheckText, ListsModulesWithoutABudget) {
  const std::string some = text(cell("c", {device("d", {with_budget(periodic("a", 1ms), 300us),
                                                        periodic("b", 2ms), process(periodic("p", 1ms))})}));
  EXPECT_THAT(some, AllOf(HasSubstr("predicted load, at least:"), HasSubstr(">= 30 %"),
                          HasSubstr("modules without a budget: b\n")));
  const std::string none = text(cell("c", {device("d", {periodic("a", 1ms)})}));
  EXPECT_THAT(none,
              AllOf(HasSubstr("load not predicted; modules without a budget: a\n"), Not(HasSubstr(" % "))));
}

TEST(CheckText, WarnsOfADeadlineShorterThanTheBasicPeriod) {
  const std::string late = text(cell("c", {device("d", {periodic("a", 10ms), sporadic("alarm", 1ms)})}));
  EXPECT_THAT(
      late, HasSubstr("may miss deadlines, because conditions are checked only every 10 ms:\n      alarm\n"));
  EXPECT_THAT(text(figure1()), Not(HasSubstr("may miss deadlines")));
}

TEST(CheckText, ShowsTheReleaseSettingsOfSporadicModules) {
  auto alarm = at_once(not_before(sporadic("alarm", 10ms), 2ms));
  alarm.miss = model::Miss::error;
  EXPECT_THAT(text(cell("c", {device("d", {periodic("a", 1ms), alarm, sporadic("b", 5ms)})})), HasSubstr(R"(
    sporadic  type    deadline  priority  budget  dispatch   interarrival  when missed
    alarm     thread  10 ms     0         -       immediate  2 ms          error
    b         thread  5 ms      0         -       row        -             count
)"));
  EXPECT_THAT(
      text(cell("c", {device("d", {periodic("a", 1ms), not_before(sporadic("b", 5ms), 2ms)})})),
      AllOf(HasSubstr("budget  interarrival\n"), Not(HasSubstr("dispatch")), Not(HasSubstr("missed"))));
}

TEST(CheckText, DoesNotWarnOfTheDeadlineOfAnImmediateModule) {
  EXPECT_THAT(text(cell("c", {device("d", {periodic("a", 10ms), at_once(sporadic("alarm", 1ms))})})),
              Not(HasSubstr("may miss deadlines")));
}

TEST(CheckText, PredictsTheMaximumLoadOfSporadicThreadModules) {
  // A row releases a sporadic module at most once. So with an interarrival time of 1.5 rows, only every
  // second row can release the module.
  const auto of = [](std::vector<model::Module> modules) {
    modules.push_back(with_budget(periodic("a", 1ms), 300us));
    return text(cell("c", {device("d", modules)}));
  };
  EXPECT_THAT(of({with_budget(sporadic("s", 5ms), 100us)}),
              HasSubstr("\n\n    sporadic load, at most 10 %: s every 1 ms\n"));
  EXPECT_THAT(of({with_budget(not_before(sporadic("s", 5ms), 500us), 100us)}),
              HasSubstr("10 %: s every 1 ms\n"));
  EXPECT_THAT(of({with_budget(not_before(sporadic("s", 5ms), 1ms), 100us)}),
              HasSubstr("10 %: s every 1 ms\n"));
  EXPECT_THAT(of({with_budget(not_before(sporadic("s", 5ms), 1500us), 100us)}),
              HasSubstr("5 %: s every 2 ms\n"));
  EXPECT_THAT(of({at_once(with_budget(not_before(sporadic("s", 5ms), 1500us), 300us))}),
              HasSubstr("20 %: s every 1.5 ms\n"));
  EXPECT_THAT(
      of({with_budget(sporadic("s", 5ms), 100us), with_budget(not_before(sporadic("t", 5ms), 4ms), 100us)}),
      AllOf(HasSubstr("12.5 %: s every 1 ms, t every 4 ms\n"), Not(HasSubstr("overload of one CPU"))));
  EXPECT_THAT(of({with_budget(not_before(sporadic("s", 5ms), Nanoseconds::max()), 100us)}),
              HasSubstr("at most 1.084e-12 %: s every "));
  EXPECT_THAT(
      text(cell("c", {device("d", {at_once(with_budget(not_before(sporadic("s", 5ms), 1ns), 1ns))})})),
      HasSubstr("at most 100 %: s every 1 ns\n"));
  // Process modules run on other CPUs than the row, so they do not add to the sporadic load.
  EXPECT_THAT(of({process(with_budget(sporadic("s", 5ms), 100us))}), Not(HasSubstr("sporadic load")));
}

TEST(CheckText, ListsSporadicModulesWithUnboundedLoad) {
  const std::string some =
      text(cell("c", {device("d", {periodic("a", 1ms), with_budget(sporadic("s", 5ms), 100us),
                                   sporadic("t", 5ms), at_once(with_budget(sporadic("u", 5ms), 100us))})}));
  EXPECT_THAT(some, AllOf(HasSubstr("    sporadic modules without a budget: t\n"),
                          HasSubstr("    sporadic modules, immediate, without interarrival: u\n")));
  EXPECT_THAT(text(figure1()), Not(HasSubstr("sporadic modules without")));
}

TEST(CheckText, WarnsIfTheTotalLoadExceedsOneCpu) {
  const auto together = [](Nanoseconds budget) {
    return text(cell("c", {device("d", {with_budget(periodic("a", 1ms), 500us),
                                        with_budget(sporadic("s", 5ms), budget)})}));
  };
  EXPECT_THAT(together(500us), Not(HasSubstr("overload of one CPU")));
  EXPECT_THAT(together(501us),
              HasSubstr("overload of one CPU if all events occur as often as allowed: 100.1 %\n"));
}

TEST(CheckText, PredictsNoLoadIfAllModulesArePrograms) {
  EXPECT_THAT(text(cell("c", {device("d", {process(periodic("p", 1ms))})})),
              AllOf(HasSubstr("    0    0 ns    p (process)\n"), Not(HasSubstr("load"))));
}

model::Cell robot_and_line(std::vector<model::Connection> connections) {
  return connected(
      cell("c", {device("robot", {periodic("arm", 1ms)}), device("line", {periodic("belt", 100ms)})}),
      std::move(connections));
}

TEST(CheckText, ShowsConnectionsWithTheirSettings) {
  EXPECT_THAT(text(robot_and_line(
                  {latest("robot.arm.out", "line.belt.in"), queue("line.belt.part", "robot.arm.part", 8)})),
              testing::EndsWith(R"(

connections
  from            to              kind        reliability
  robot.arm.out   line.belt.in    latest      best-effort
  line.belt.part  robot.arm.part  queue of 8  reliable
)"));
  auto outside = on_topic(latest("robot.arm.out", ""), "rt/arm");
  outside.lifespan = 1s;
  outside.domain = 3;
  EXPECT_THAT(text(robot_and_line({outside, stale_after(on_topic(latest("", "line.belt.in"), "b"), 20ms)})),
              testing::EndsWith(R"(
connections
  from            to              kind    reliability  deadline  stale  lifespan  topic
  robot.arm.out   other programs  latest  best-effort  -         -      1 s       rt/arm in domain 3
  other programs  line.belt.in    latest  best-effort  20 ms     hold   -         b
)"));
  EXPECT_THAT(text(robot_and_line({})), Not(HasSubstr("connections")));
}

TEST(CheckText, ShowsAConnectionOnTwoLinesIfTheTableIsTooWide) {
  const auto connection = stale_after(
      on_topic(queue("robot.arm.out", "line.belt.in", 4), std::string(70, 't')), 20ms, model::Stale::error);
  EXPECT_THAT(text(robot_and_line({connection}), {.width = 80}), testing::EndsWith(R"(
connections
  robot.arm.out -> line.belt.in
    queue of 4, reliable, deadline 20 ms, error when stale, topic
    )" + std::string(70, 't') + "\n"));
}

TEST(CheckText, ShowsOnlyTheFirstOfManyConnections) {
  std::vector<model::Connection> many;
  for (int i = 0; i < 150; ++i) many.push_back(latest("robot.arm.out", "line.belt.in" + std::to_string(i)));
  EXPECT_THAT(text(robot_and_line(many)),
              AllOf(HasSubstr("line.belt.in99 "), Not(HasSubstr("line.belt.in100")),
                    HasSubstr("  ... and 50 more; takt graph --json lists them all\n")));
}

// The belt writes every 100 ms, and the arm runs every 1 ms. So just before each write, the arm reads a value
// that is 99 ms old.
TEST(CheckText, WarnsOfAConnectionThatBecomesStaleBetweenTwoWrites) {
  const auto of = [](Nanoseconds deadline) {
    return text(robot_and_line({stale_after(latest("line.belt.out", "robot.arm.in"), deadline)}));
  };
  EXPECT_THAT(of(98ms),
              HasSubstr("  inputs that go stale between two writes, because the deadline is too short:\n"
                        "    robot.arm.in, whose writer runs only every 100 ms\n"));
  EXPECT_THAT(of(99ms), Not(HasSubstr("go stale between")));
  EXPECT_THAT(text(robot_and_line({stale_after(queue("line.belt.out", "robot.arm.in", 4), 98ms)})),
              HasSubstr("go stale between"))
      << "the newest sample of a queue gets as old as a latest value";
  // A reader that is as slow as its writer may see a new value in each run. The times at which a sporadic
  // reader runs cannot be predicted.
  EXPECT_THAT(text(robot_and_line({stale_after(latest("robot.arm.out", "line.belt.in"), 1us)})),
              Not(HasSubstr("go stale between")));
  const auto by_events = cell("c", {device("d", {periodic("a", 100ms), sporadic("s", 1ms)})});
  EXPECT_THAT(text(connected(by_events, {stale_after(latest("d.a.out", "d.s.in"), 1us)})),
              Not(HasSubstr("go stale between")));
}

TEST(CheckText, ShowsHowNodesDiscoverEachOther) {
  auto two = robot_and_line({});
  EXPECT_THAT(text(two),
              testing::StartsWith("cell c: 2 devices, 2 modules\ndomain 0, discovery by multicast\n\n"));
  two.domain = 7;
  two.discovery = {model::Discovery::Kind::peers, {"10.0.0.1", "line.local"}, {}, {}};
  EXPECT_THAT(text(two), HasSubstr("\ndomain 7, discovery by peers: 10.0.0.1 line.local\n"));
  two.discovery = {model::Discovery::Kind::server, {}, "robot:11811", {}};
  EXPECT_THAT(text(two), HasSubstr("\ndomain 7, discovery by server robot:11811\n"));
  two.server_device = "robot";
  EXPECT_THAT(text(two),
              HasSubstr("\ndomain 7, discovery by server robot:11811, which the node of robot starts\n"));
  EXPECT_THAT(text(figure1()), Not(HasSubstr("discovery")));
}

TEST(CheckText, ListsTheInputsWithoutAConnection) {
  model::Cell cell = robot_and_line({latest("line.belt.out", "robot.arm.in")});
  cell.file = "cell.xml";
  for (std::size_t i = 0; i < 2; ++i) cell.devices[i].modules[0].line = static_cast<int>(4 + i);
  model::CellPorts ports;
  for (const model::Device& device : cell.devices) ports.emplace_back(device.modules.size());
  ports[0][0] = std::vector<model::Port>{{"in", model::Direction::in, {}, ""},
                                         {"reset", model::Direction::in, {}, ""},
                                         {"tick", model::Direction::event, {}, ""},
                                         {"out", model::Direction::out, {}, ""}};
  EXPECT_THAT(check_text(cell, plans(cell), {}, std::nullopt, ports),
              testing::EndsWith("\n\ninputs without a connection, which never get a value\n"
                                "  robot.arm, on line 4: reset, tick\n"));
  ports[0][0]->resize(1);
  EXPECT_THAT(check_text(cell, plans(cell), {}, std::nullopt, ports), Not(HasSubstr("without a connection")));
}

TEST(CheckText, ShowsExecutorsWithoutPeriodicModules) {
  EXPECT_THAT(text(palletizing()),
              AllOf(HasSubstr("basic period 4 ms, half the shortest deadline"),
                    HasSubstr("executor spare: any cpu, priority 80, wakeup hybrid\n    no modules\n")));
}

TEST(CheckText, ShowsTheStartOfALongTableAndCountsTheRest) {
  // No two consecutive rows are equal, so the report cannot merge them.
  const std::string all = text(cell("c", {device("d", {periodic("a", 2ms), periodic("b", 7919ms)})}));
  EXPECT_THAT(all, AllOf(HasSubstr("39   39 ms"), Not(HasSubstr("\n    40 ")),
                         HasSubstr("... and 15798 rows more; --json lists them all")));
}

TEST(CheckText, ShortensALongListOfModules) {
  std::vector<model::Module> modules;
  for (int i = 0; i < 1000; ++i) modules.push_back(periodic("m" + std::to_string(i), 1ms));
  for (int i = 0; i < 100; ++i) modules.push_back(sporadic("s" + std::to_string(i), 1ms));
  const std::string all = text(cell("c", {device("d", modules)}));
  EXPECT_THAT(all, AllOf(HasSubstr("m31, and 968 more"), HasSubstr("s39 "), Not(HasSubstr("s40")),
                         HasSubstr("... and 60 more")));
}

TEST(CheckText, NeverExceedsTheWidthOfTheTerminal) {
  for (const model::Cell& cell : {figure1(), palletizing(), widest_cell()}) {
    EXPECT_LE(widest(text(cell, {.width = 100})), 100U) << text(cell);
    EXPECT_LE(widest(text(cell, {.width = 80})), 80U) << text(cell, {.width = 80});
    EXPECT_LE(widest(text(cell, {.width = 1000})), 100U);
    EXPECT_LE(widest(text(cell, {.width = 0})), 80U);
  }
}

TEST(CheckText, UsesEscapeSequencesOnlyForColour) {
  const std::string plain = text(palletizing());
  std::string coloured = text(palletizing(), {.colour = true});
  EXPECT_EQ(plain.find('\x1b'), std::string::npos);
  ASSERT_NE(coloured.find('\x1b'), std::string::npos);
  for (std::size_t at = 0; (at = coloured.find('\x1b')) != std::string::npos;) {
    coloured.erase(at, coloured.find('m', at) - at + 1);
  }
  EXPECT_EQ(coloured, plain);
}

TEST(CheckText, HasNoTrailingSpaces) {
  for (const std::string& line :
       lines(text(palletizing()) + text(widest_cell()) + text(widest_cell(), {.width = 80}))) {
    EXPECT_TRUE(line.empty() || line.back() != ' ') << line;
  }
}

// ---- JSON

TEST(CheckJson, IsTheExpectedObjectForThePapersFigure1) {
  const auto expected = nlohmann::ordered_json::parse(R"({
    "cell": "module", "devices": [{"name": "module",
      "executors": [{"name": "main", "basic_period_ns": 100000, "macro_period_ns": 600000,
        "rows": [["control3", "control2", "controller1", "control4"], ["control3", "control2"], ["control3", "control2"],
                 ["control3", "control2", "control4"], ["control3", "control2"], ["control3", "control2"]],
        "sporadic": ["emergency", "vision"]}],
      "non_realtime": ["monitoring"]}]})");
  const model::Cell cell = figure1();
  EXPECT_EQ(check_json(cell, plans(cell)).dump(), expected.dump());
}

// Other programs rely on the members of the JSON object that `takt check` prints. Only `takt graph --json`
// contains connections and services.
TEST(CheckJson, OmitsConnections) {
  auto module = at_once(not_before(sporadic("s", 10ms), 1ms));
  module.miss = model::Miss::error;
  const model::Cell cell = connected(cells::cell("c", {device("d", {periodic("a", 1ms), module})}),
                                     {queue("d.a.out", "d.s.in", 8), on_topic(latest("d.a.x", ""), "t")});
  EXPECT_EQ(check_json(cell, plans(cell)).dump(),
            R"({"cell":"c","devices":[{"name":"d","executors":[{"name":"main","basic_period_ns":1000000,)"
            R"("macro_period_ns":1000000,"rows":[["a"]],"sporadic":["s"]}],"non_realtime":[]}]})");
}

TEST(CheckJson, HasEmptyArraysForAnEmptyCell) {
  const model::Cell cell =
      cells::cell("c", {device("d", {sporadic("s", 10ns)}, {"main", "spare"}), device("e", {})});
  const auto expected = nlohmann::ordered_json::parse(R"({
    "cell": "c", "devices": [
      {"name": "d", "executors": [
        {"name": "main", "basic_period_ns": 5, "macro_period_ns": 5, "rows": [[]], "sporadic": ["s"]},
        {"name": "spare", "basic_period_ns": 0, "macro_period_ns": 0, "rows": [], "sporadic": []}], "non_realtime": []},
      {"name": "e", "executors": [
        {"name": "main", "basic_period_ns": 0, "macro_period_ns": 0, "rows": [], "sporadic": []}], "non_realtime": []}]})");
  EXPECT_EQ(check_json(cell, plans(cell)).dump(), expected.dump());
  EXPECT_EQ(check_json(cells::cell("none", {}), {}).dump(), R"({"cell":"none","devices":[]})");
}

Proof proof_of(const model::Cell& cell, const std::vector<std::optional<Nanoseconds>>& runs) {
  Proof proof;
  proof.cpus = 2;
  const model::Device& device = cell.devices[0];
  proof.devices = {schedule::worst_cases(device, plans(cell)[0], schedule::place(device, model::Cpus::all({0, 1})), runs)};
  return proof;
}

TEST(CheckText, ShowsTheWorstResponseTimeOfEachModule) {
  const model::Cell cell =
      cells::cell("c", {device("d", {periodic("a", 1ms), sporadic("s", 1ms), non_real("n")})});
  EXPECT_THAT(check_text(cell, plans(cell), {}, proof_of(cell, {300us, 400us, std::nullopt})), HasSubstr(R"(
  worst-case response times, computed from the budgets, on 2 CPUs:
    module  cpu  longest run  response  deadline  slack
    a       1    300 us       300 us    1 ms      700 us  kept
    s       1    400 us       800 us    1 ms      200 us  kept
)"));
  EXPECT_THAT(check_text(cell, plans(cell), {}, proof_of(cell, {300us, 700us, std::nullopt})), HasSubstr(R"(
    s       1    700 us       1.5 ms    1 ms      -500 us  NOT KEPT
)"));
  model::Cell unlimited = cell;
  unlimited.devices[0].modules[1].dispatch = model::Dispatch::immediate;
  EXPECT_THAT(check_text(unlimited, plans(unlimited), {}, proof_of(unlimited, {300us, 400us, std::nullopt})),
              HasSubstr("NOT PROVEN"));
}

TEST(CheckText, ShowsMissedDeadlinesEvenInAShortenedList) {
  std::vector<model::Module> modules;
  for (std::size_t i = 0; i < kTextRows + 10; ++i) modules.push_back(periodic("m" + std::to_string(i), 1ms));
  const model::Cell cell = cells::cell("c", {device("d", modules)});
  const std::vector<std::optional<Nanoseconds>> short_runs(modules.size(), 1us);
  EXPECT_THAT(check_text(cell, plans(cell), {}, proof_of(cell, short_runs)),
              HasSubstr("... and 10 more, all kept; --json lists them all"));
  auto runs = short_runs;
  runs.back() = 990us;
  EXPECT_THAT(check_text(cell, plans(cell), {}, proof_of(cell, runs)), HasSubstr("m49 "));
}

TEST(CheckJson, ContainsTheWorstResponseTimeOfEachModule) {
  const model::Cell cell = cells::cell("c", {device("d", {periodic("a", 1ms), at_once(sporadic("s", 1ms))})});
  auto proof = proof_of(cell, {300us, 700us});
  proof.of_profile = true;
  proof.factor = 1.5;
  EXPECT_EQ(check_json(cell, plans(cell), proof)["devices"][0]["worst_case"].dump(),
            R"({"processors":2,"factor":1.5,"run_times":"profile","modules":[)"
            R"({"name":"a","cpus":[1],"run_ns":300000,"response_ns":300000,"deadline_ns":1000000,)"
            R"("slack_ns":700000,"kept":true},)"
            R"({"name":"s","cpus":[1],"run_ns":700000,"response_ns":null,"deadline_ns":1000000,)"
            R"("slack_ns":null,"kept":false,"why":"the minimum time between its releases is not known"}]})");
}

TEST(CheckJson, ContainsEveryRowOfALongTable) {
  const model::Cell cell = cells::cell("c", {device("d", {periodic("a", 1us), periodic("b", 100ms)})});
  EXPECT_EQ(check_json(cell, plans(cell))["devices"][0]["executors"][0]["rows"].size(), 100'000U);
}

// ---- Drawing

std::string svg(const model::Cell& cell) { return check_svg(cell, plans(cell)); }

model::Cell crowded_cell() {
  std::vector<model::Module> modules;
  for (int i = 0; i < 150; ++i) {
    modules.push_back(with_budget(
        periodic(long_name('a').substr(4) + std::to_string(1000 + i), 1ms * (1 + i % 2), i), 2us));
    modules.push_back(sporadic("s" + std::to_string(i), 3ms));
    modules.push_back(non_real("n" + std::to_string(i)));
  }
  modules.push_back(process(with_budget(periodic("slow", 2s), 1s)));
  return cell("crowded", {device("d", modules)});
}

class DrawnCell : public testing::TestWithParam<int> {
 protected:
  static model::Cell drawn() {
    switch (GetParam()) {
      case 0:
        return cell("none", {});
      case 1:
        return figure1();
      case 2:
        return palletizing();
      case 3:
        return widest_cell();
      case 4:
        return crowded_cell();
      default:
        return cell("long", {device("d", {with_budget(periodic("a", 2ms), 300us), periodic("b", 7919ms)})});
    }
  }
};

TEST_P(DrawnCell, IsWellFormedXml) { EXPECT_TRUE(is_well_formed(svg(drawn()))); }

TEST_P(DrawnCell, HasNoClippedOrOverlappingText) { expect_readable(svg(drawn())); }

INSTANTIATE_TEST_SUITE_P(CheckSvg, DrawnCell, testing::Range(0, 6));

TEST(CheckSvg, NumbersReleasesInTheOrderOfTheirRow) {
  const std::string drawing = svg(figure1());
  EXPECT_EQ(occurrences(drawing, R"(class="on">1</text>)"), 6U + 1);  // plus one in the legend
  EXPECT_EQ(occurrences(drawing, R"(class="on">2</text>)"), 6U + 1);
  EXPECT_EQ(occurrences(drawing, R"(class="on">3</text>)"), 2U);
  EXPECT_EQ(occurrences(drawing, R"(class="on">4</text>)"), 1U);
}

TEST(CheckSvg, ShowsPeriodsModulesAndDeadlines) {
  EXPECT_THAT(
      svg(figure1()),
      AllOf(
          HasSubstr("basic period 100 us, macro period 600 us, 6 rows; any cpu, priority 80, wakeup hybrid"),
          HasSubstr(">controller1<"), HasSubstr("thread, every 600 us, priority 3"),
          HasSubstr("process, deadline 10 ms, priority 2"), HasSubstr(">600 us<"),
          HasSubstr("not real-time: monitoring (process)"), HasSubstr("no thread has a budget"),
          HasSubstr("prefers-color-scheme: dark")));
}

TEST(CheckSvg, DrawsBudgetsToScale) {
  // One row is 240 pixels wide. The second thread module begins when the first one has used its budget, and
  // the process module begins at the release.
  const std::string drawing = svg(cell(
      "c", {device("d", {with_budget(periodic("a", 1ms, 1), 250us), with_budget(periodic("b", 1ms, 2), 500us),
                         process(with_budget(periodic("p", 1ms, 3), 750us))})}));
  const std::regex bar{
      R"re(<rect x="([0-9.]+)" y="[0-9.]+" width="([0-9.]+)" height="6.0" rx="0" class="(\w+)-budget")re"};
  std::vector<std::array<double, 2>> bars;
  for (std::sregex_iterator at{drawing.begin(), drawing.end(), bar}, end; at != end; ++at) {
    bars.push_back({std::stod((*at)[1]), std::stod((*at)[2])});
  }
  ASSERT_EQ(bars.size(), 3U);
  EXPECT_NEAR(bars[0][1], 60, 0.2);
  EXPECT_NEAR(bars[1][0], bars[0][0] + 60, 0.2);
  EXPECT_NEAR(bars[1][1], 120, 0.2);
  EXPECT_NEAR(bars[2][0], bars[0][0], 0.2);
  EXPECT_NEAR(bars[2][1], 180, 0.2);
  EXPECT_THAT(drawing, HasSubstr(">75%<"));
}

TEST(CheckSvg, DrawsAScaleIfTheLoadNumbersDoNotFit) {
  const std::string wide = svg(cell("c", {device("d", {with_budget(periodic("a", 1ms), 250us)})}));
  EXPECT_THAT(wide, AllOf(HasSubstr(">25%<"), Not(HasSubstr(">100%<"))));
  const std::string narrow =
      svg(cell("c", {device("d", {with_budget(periodic("a", 1ms), 250us), periodic("b", 60ms)})}));
  EXPECT_THAT(narrow, AllOf(Not(HasSubstr("25%<")), HasSubstr(">100%<")));
  expect_readable(narrow);
}

TEST(CheckSvg, HasALegendOnlyForWhatIsDrawn) {
  const std::string plain = svg(cell("c", {device("d", {periodic("a", 1ms)})}));
  EXPECT_THAT(plain, HasSubstr("release of a thread module"));
  for (const char* other : {"release of a process module", "budget, to scale",
                            "end of the row: ", "deadline of", "load of a row"})
    EXPECT_THAT(plain, Not(HasSubstr(other)));
  EXPECT_THAT(svg(figure1()), AllOf(HasSubstr("release of a process module"), HasSubstr("end of the row: "),
                                    HasSubstr("deadline of"), Not(HasSubstr("budget, to scale"))));
  EXPECT_THAT(svg(cell("c", {device("d", {with_budget(periodic("a", 1ms), 250us)})})),
              AllOf(HasSubstr("budget, to scale"), HasSubstr("load of a row: up to 70%, up to 90%")));
}

TEST(CheckSvg, SaysWhichRowsAndModulesAreNotDrawn) {
  EXPECT_THAT(svg(cell("long", {device("d", {periodic("a", 2ms), periodic("b", 7919ms)})})),
              HasSubstr("only rows 0 to 63 of 15838 are drawn"));
  EXPECT_THAT(svg(crowded_cell()),
              AllOf(HasSubstr("and 51 more periodic modules"), HasSubstr("and 50 more sporadic modules")));
  EXPECT_THAT(svg(figure1()), Not(HasSubstr("are drawn")));
}

TEST(CheckSvg, EscapesSpecialCharactersInNames) {
  EXPECT_THAT(svg(cell("a<b>&\"c\"", {})),
              AllOf(HasSubstr("a&lt;b&gt;&amp;&quot;c&quot;"), Not(HasSubstr("a<b>"))));
}

TEST(CheckSvg, HasNoExternalReferences) {
  const std::string drawing = svg(palletizing());
  EXPECT_EQ(occurrences(drawing, "http"), 1U) << "the namespace";
  EXPECT_THAT(drawing, AllOf(Not(HasSubstr("href")), Not(HasSubstr("@import")), Not(HasSubstr("<script"))));
}

}  // namespace
}  // namespace takt::tool::check_report_test
