#include "reports/graph_report.hpp"

#include <algorithm>
#include <random>
#include <sstream>
#include <tuple>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cells.hpp"
#include "drawing/graph_layout.hpp"
#include "pictures.hpp"

namespace takt::tool::graph_report_test {
namespace {

using namespace cells;
using namespace drawings;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

std::string long_name(char letter) { return std::string(63, letter); }

/// Returns a cell of a robot, a line and a station, with connections to a program outside Takt.
model::Cell three() {
  auto dispatcher = at_once(not_before(sporadic("dispatcher", 10ms), 1ms));
  auto result = connected(
      cell("palletizing", {device("robot", {periodic("trajectory", 1ms), periodic("arm", 1ms)}),
                           device("line", {periodic("belt", 2ms), process(non_real("logger"))}),
                           device("station", {dispatcher})}),
      {stale_after(latest("robot.trajectory.setpoint", "robot.arm.setpoint"), 20ms, model::Stale::error),
       queue("line.belt.part", "station.dispatcher.part", 8),
       queue("station.dispatcher.request", "robot.trajectory.request", 8),
       latest("robot.arm.measured", "line.belt.arm"), on_topic(latest("robot.arm.measured", ""), "rt/arm"),
       on_topic(latest("", "line.belt.speed"), "rt/speed")});
  result.connections.back().domain = 3;
  return result;
}

CellHealth running() {
  CellHealth health;
  health.devices["robot"] = {true, ""};
  health.devices["line"] = {true, "belt is in RECOVER"};
  health.devices["station"] = {false, ""};
  health.modules = {{"robot.trajectory", "EXECUTING"},
                    {"robot.arm", "EXECUTING"},
                    {"line.belt", "RECOVER"},
                    {"station.dispatcher", "EXECUTING"}};
  health.connections[0].age = 1200us;
  health.connections[1] = {.age = 3ms, .losing = true, .lost = 3, .dropped = 2};
  health.connections[2] = {.matched = false};
  health.connections[3] = {.age = 900ms, .deadline = 20ms, .late = 1};
  health.connections[4] = {.matched = false, .incompatible = "reliability"};
  return health;
}

std::string text(const model::Cell& cell, const CellHealth& health = {}, Style style = {}) {
  return graph_text(cell, health, style);
}

// ---- Text

nlohmann::ordered_json port(const char* name, int connections, int matched) {
  return {{"name", name},       {"direction", "in"}, {"type", "t::T"},    {"connections", connections},
          {"matched", matched}, {"samples", 7},      {"lost", 0},         {"dropped", 0},
          {"refused", 0},       {"late", 0},         {"age_us", nullptr}, {"incompatible", nullptr}};
}

/// Returns the object that `takt status --json` prints for three(). The station is lost, and the line is not
/// connected to the robot.
nlohmann::ordered_json status_of_three() {
  auto setpoint = port("setpoint", 1, 1);
  setpoint["age_us"] = 30000.5;
  setpoint["late"] = 2;
  setpoint["dropping"] = true;
  auto arm = port("arm", 1, 0);
  arm["incompatible"] = "reliability";
  const auto module = [](const char* name, const char* state, nlohmann::ordered_json ports) {
    return nlohmann::ordered_json{{"name", name}, {"state", state}, {"ports", std::move(ports)}};
  };
  using List = nlohmann::ordered_json;
  return {{"cell", "other, palletizing"},
          {"devices",
           List::array(
               {{{"name", "robot"},
                 {"alive", true},
                 {"modules",
                  List::array({module("trajectory", "EXECUTING", List::array({port("request", 1, 0)})),
                               module("arm", "RECOVER", List::array({setpoint, port("measured", 2, 2)}))})}},
                {{"name", "line"},
                 {"alive", true},
                 {"modules", List::array({module("belt", "EXECUTING", List::array({arm}))})}},
                {{"name", "station"},
                 {"alive", false},
                 {"modules", List::array({{{"name", "dispatcher"}, {"state", "EXECUTING"}}})}},
                {{"name", "stranger"}, {"alive", true}, {"modules", List::array()}}})}};
}

TEST(CellHealth, TakesConnectionHealthFromTheReadingDevice) {
  const CellHealth health = health_of(three(), status_of_three());
  EXPECT_EQ(health.devices.size(), 3U);
  EXPECT_FALSE(health.devices.at("station").alive);
  EXPECT_EQ(health.modules.at("robot.arm"), "RECOVER");
  EXPECT_EQ(health.modules.at("station.dispatcher"), "EXECUTING");
  const auto& setpoint = health.connections.at(0);
  EXPECT_TRUE(setpoint.matched && setpoint.stale() && setpoint.dropping);
  EXPECT_EQ(setpoint.age, 30'000'500ns);
  EXPECT_EQ(health_text(setpoint), "STALE, 30 ms old, late 2") << "rounded to a useful precision";
  EXPECT_EQ(setpoint.late, 2U);
  EXPECT_EQ(health_text(health.connections.at(1)), "NOT MATCHED")
      << "the station is lost, and reports nothing";
  EXPECT_FALSE(health.connections.at(2).matched);
  EXPECT_EQ(health.connections.at(3).incompatible, "reliability");
  EXPECT_TRUE(health.connections.at(4).matched) << "a topic for other programs has only a writer";
  EXPECT_FALSE(health.connections.contains(5));
}

TEST(CellHealth, RatesAQueueAsPoorInTextJsonAndDrawingWhileItDropsSamples) {
  auto cell = three();
  CellHealth health;
  health.connections[0] = {.age = 1ms};
  const auto rating = [&] { return graph_json(cell, health)["connections"][0]["health"]["rating"]; };
  health.connections[0].dropped = 27757;
  EXPECT_EQ(rating(), "good") << "that was long ago";
  EXPECT_EQ(health_text(health.connections[0]), "ok, 1 ms old, dropped 27757");
  health.connections[0].dropping = true;
  EXPECT_EQ(rating(), "poor");
  EXPECT_EQ(health_text(health.connections[0]), "degraded: drops samples, 1 ms old, dropped 27757");
  EXPECT_THAT(graph_svg(cell, health),
              HasSubstr("poor-word state\">degraded: drops samples, 1 ms old, dropped 27757"));
  const std::string amber = "\x1b[33m    ! degraded: drops samples, 1 ms old, dropped 27757\x1b[0m\n";
  EXPECT_THAT(text(cell, health, {.colour = true}), HasSubstr(amber));
}

TEST(CellHealth, HasNoConnectionsOfADeviceThatDoesNotRun) {
  auto status = status_of_three();
  status["devices"][0]["state"] = "running";
  EXPECT_TRUE(health_of(three(), status).connections.contains(0));
  status["devices"][0]["state"] = "ended";
  EXPECT_FALSE(health_of(three(), status).connections.contains(0)) << "its values only grow old";
}

TEST(CellHealth, IsGoodWithoutAValueThatNoDeadlineDemands) {
  for (const auto kind : {model::ConnectionKind::queue, model::ConnectionKind::latest}) {
    model::Connection connection = latest("a.m.y", "b.m.y");
    connection.kind = kind;
    const auto health = health_of({.matched = true}, &connection, false);
    EXPECT_EQ(wire::judge(health).rating, wire::Rating::good);
    EXPECT_EQ(health_text(health), "ok: no value yet");
  }
}

TEST(CellHealth, IsGoodIfNoOtherProgramUsesTheTopicOfAConnectionWithoutADeadline) {
  const ObservedCell::Port alone{.matched = false};
  for (const auto& [from, to] : {std::pair{"", "b.m.y"}, std::pair{"a.m.y", ""}}) {
    model::Connection connection = on_topic(latest(from, to), "plant/speed");
    const auto health = [&] { return health_of(alone, &connection, false); };
    EXPECT_EQ(wire::judge(health()).rating, wire::Rating::good);
    EXPECT_EQ(health_text(health()),
              *to == '\0' ? "no other program reads it" : "no other program writes it");
    EXPECT_EQ(health_text(health_of(alone, &connection, true)), "NOT MATCHED") << "its device is lost";
    EXPECT_EQ(health_text(health_of({.incompatible = "reliability"}, &connection, false)),
              "NOT MATCHED: reliability");
  }
  model::Connection needed = on_topic(latest("", "b.m.y"), "plant/speed");
  needed.deadline = 20ms;
  EXPECT_EQ(health_text(health_of(alone, &needed, false)), "STALE") << "the reader needs a value";
  const model::Connection within = latest("a.m.y", "b.m.y");
  EXPECT_EQ(health_text(health_of(alone, &within, false)), "NOT MATCHED");
}

TEST(CellHealth, ShowsConnectionsOfALostDeviceAsUnmatched) {
  for (const char* lost : {"robot", "line"}) {
    auto status = status_of_three();
    for (auto& device : status["devices"]) {
      device["alive"] = device["name"] != lost;
      if (device["name"] == "line") device["modules"][0]["ports"][0]["matched"] = 1;
    }
    const CellHealth health = health_of(three(), status);
    EXPECT_FALSE(health.connections.at(3).matched) << "from the robot to the line, without the " << lost;
    EXPECT_EQ(health.connections.at(0).matched, lost != std::string{"robot"}) << "within the robot";
  }
}

TEST(CellHealth, DoesNotJudgeAConnectionWhoseReaderWaitsForItsFirstRelease) {
  auto status = status_of_three();
  auto& arm = status["devices"][0]["modules"][1];
  arm["state"] = "START";
  EXPECT_FALSE(health_of(three(), status).connections.contains(0));
  arm["stopped"] = true;
  EXPECT_TRUE(health_of(three(), status).connections.contains(0)) << "an operator stopped the reader";
}

TEST(CellHealth, DrawsDestructRedOnlyIfTheModuleWasGivenUp) {
  auto status = status_of_three();
  auto& arm = status["devices"][0]["modules"][1];
  arm["state"] = "DESTRUCT";
  const auto drawing = [&] { return graph_svg(three(), health_of(three(), status)); };
  EXPECT_THAT(drawing(), HasSubstr("class=\"faint state\">DESTRUCT<")) << "it has finished, or was ended";
  arm["given_up"] = true;
  EXPECT_THAT(drawing(), HasSubstr("class=\"bad-word state\">DESTRUCT<"));
}

TEST(CellHealth, IsEmptyIfTheCellDoesNotRun) {
  auto status = status_of_three();
  status["cell"] = "palletizing2, other";
  EXPECT_TRUE(health_of(three(), status).devices.empty());
}

TEST(GraphText, ListsModulesAndConnections) {
  EXPECT_EQ(text(three()), R"(cell palletizing: 3 devices, 5 modules, 6 connections
domain 0, discovery by multicast

device robot
  module      type    operation             executor
  trajectory  thread  periodic, every 1 ms  main
  arm         thread  periodic, every 1 ms  main

device line
  module  type     operation             executor
  belt    thread   periodic, every 2 ms  main
  logger  process  non-real              -

device station
  module      type    operation                                               executor
  dispatcher  thread  sporadic, deadline 10 ms, immediate, interarrival 1 ms  main

connections
  robot.trajectory.setpoint -> robot.arm.setpoint
    latest, best-effort, deadline 20 ms, error when stale
  line.belt.part -> station.dispatcher.part
    queue of 8, reliable
  station.dispatcher.request -> robot.trajectory.request
    queue of 8, reliable
  robot.arm.measured -> line.belt.arm
    latest, best-effort
  robot.arm.measured -> other programs
    latest, best-effort, topic rt/arm
  other programs -> line.belt.speed
    latest, best-effort, topic rt/speed in domain 3
)");
}

TEST(GraphText, ShowsTheHealthOfARunningCell) {
  EXPECT_THAT(
      text(three(), running()),
      AllOf(HasSubstr("device robot\n  alive\n"), HasSubstr("device line\n  alive\n  belt is in RECOVER\n"),
            ContainsRegex("device station\n  LOST\n  dispatcher\n .*, LOST, was\n +EXECUTING\n"),
            HasSubstr("belt    thread   periodic, every 2 ms  main      RECOVER\n"),
            HasSubstr("logger  process  non-real              -         -\n"),
            HasSubstr("    ok, 1.2 ms old\n"),
            HasSubstr("    ! degraded: loses samples, 3 ms old, lost 3, dropped 2\n"),
            HasSubstr("    X NOT MATCHED\n"), HasSubstr("    X STALE, 900 ms old, late 1\n"),
            HasSubstr("    X NOT MATCHED: reliability\n")));
  const auto two =
      connected(cell("c", {device("a", {periodic("m", 1ms)}), device("b", {periodic("m", 1ms)})}),
                {latest("a.m.x", "b.m.x"), latest("a.m.y", "b.m.y")});
  CellHealth one;
  one.connections[1] = {};
  EXPECT_THAT(text(two, one), testing::EndsWith("connections\n"
                                                "  from   to     kind    reliability  now\n"
                                                "  a.m.x  b.m.x  latest  best-effort  -\n"
                                                "  a.m.y  b.m.y  latest  best-effort  ok: no value yet\n"));
}

TEST(GraphText, NeverExceedsTheWidthOfTheTerminal) {
  const auto wide = connected(
      cell(long_name('c'), {device(long_name('d'), {on(long_name('e'), periodic(long_name('m'), 1ms))})}),
      {on_topic(latest(long_name('d') + "." + long_name('m') + "." + long_name('p'), ""),
                std::string(255, 't'))});
  CellHealth health;
  health.devices[long_name('d')] = {false, std::string(200, 'w')};
  health.modules[long_name('d') + "." + long_name('m')] = "EXECUTING";
  health.connections[0] = {.incompatible = std::string(200, 'i')};
  for (const auto& [cell, state] : {std::pair{three(), running()}, std::pair{wide, health}}) {
    for (const std::size_t width : {80U, 100U}) {
      std::istringstream lines{text(cell, state, {.width = width})};
      for (std::string line; std::getline(lines, line);) {
        EXPECT_LE(line.size(), width) << line;
        EXPECT_TRUE(line.empty() || line.back() != ' ') << line;
      }
    }
    std::string coloured = text(cell, state, {.colour = true});
    ASSERT_NE(coloured.find('\x1b'), std::string::npos);
    for (std::size_t at = 0; (at = coloured.find('\x1b')) != std::string::npos;)
      coloured.erase(at, coloured.find('m', at) - at + 1);
    EXPECT_EQ(coloured, text(cell, state));
  }
}

TEST(GraphText, ShowsOnlyTheFirstOfManyModules) {
  std::vector<model::Module> many;
  for (int i = 0; i < 130; ++i) many.push_back(periodic("m" + std::to_string(i), 1ms));
  EXPECT_THAT(text(cell("c", {device("d", many)})),
              AllOf(HasSubstr("\n  m99 "), Not(HasSubstr("\n  m100")),
                    HasSubstr("... and 30 more; --json lists them all")));
}

// ---- JSON

TEST(GraphJson, ContainsAllDataOfTheDescriptor) {
  auto module = at_once(not_before(with_budget(sporadic("s", 10ms, 2), 1ms), 4ms));
  module.miss = model::Miss::error;
  auto connection = on_topic(stale_after(queue("d.a.out", "d.s.in", 8), 20ms, model::Stale::error), "rt/x");
  connection.lifespan = 1s;
  connection.domain = 3;
  auto all = connected(cell("c", {device("d", {periodic("a", 1ms, 1), module, process(non_real("n"))})}),
                       {connection, latest("d.a.x", "d.s.y"), on_topic(latest("", "d.s.z"), "t")});
  all.domain = 7;
  all.discovery = {model::Discovery::Kind::server, {}, "h:1", {}};
  all.server_device = "d";
  EXPECT_EQ(graph_json(all, {}).dump(), nlohmann::ordered_json::parse(R"({
    "cell": "c", "domain": 7, "discovery": {"kind": "server", "server": "h:1", "server_device": "d"},
    "devices": [{"name": "d", "modules": [
      {"name": "a", "type": "thread", "operation": "periodic", "period_ns": 1000000, "priority": 1, "executor": "main"},
      {"name": "s", "type": "thread", "operation": "sporadic", "deadline_ns": 10000000, "miss": "error",
       "dispatch": "immediate", "interarrival_ns": 4000000, "priority": 2, "executor": "main", "budget_ns": 1000000},
      {"name": "n", "type": "process", "operation": "non-real", "priority": 0}]}],
    "connections": [
      {"from": "d.a.out", "to": "d.s.in", "kind": "queue", "depth": 8, "reliability": "reliable", "deadline_ns": 20000000,
       "stale": "error", "lifespan_ns": 1000000000, "topic": "rt/x", "domain": 3},
      {"from": "d.a.x", "to": "d.s.y", "kind": "latest", "reliability": "best-effort", "topic": "takt/c/d/a/x"},
      {"from": null, "to": "d.s.z", "kind": "latest", "reliability": "best-effort", "topic": "t"}], "services": []})")
                                            .dump());
}

TEST(GraphJson, ContainsTheHealthOfARunningCell) {
  const auto json = graph_json(three(), running());
  EXPECT_EQ(json["devices"][0]["alive"], true);
  EXPECT_EQ(json["devices"][2]["alive"], false);
  EXPECT_EQ(json["devices"][1]["text"], "belt is in RECOVER");
  EXPECT_EQ(json["devices"][1]["modules"][0]["state"], "RECOVER");
  EXPECT_FALSE(json["devices"][1]["modules"][1].contains("state"));
  EXPECT_EQ(
      json["connections"][1]["health"].dump(),
      R"({"rating":"poor","reason":"degraded: loses samples","matched":true,"stale":false,"age_ns":3000000,"lost":3,"dropped":2,"late":0})");
  EXPECT_EQ(json["connections"][4]["health"]["incompatible"], "reliability");
  EXPECT_FALSE(json["connections"][5].contains("health"));
  EXPECT_FALSE(graph_json(three(), {}).dump().find("alive") != std::string::npos);
}

// ---- Drawing

TEST(GraphSvg, ShowsDevicesModulesAndPorts) {
  const std::string drawing = graph_svg(three(), {});
  EXPECT_THAT(drawing, AllOf(HasSubstr(">robot<"), HasSubstr(">2 modules<"), HasSubstr(">trajectory<"),
                             HasSubstr(">thread, periodic, every 1 ms<"), HasSubstr(">process, non-real<"),
                             HasSubstr(">setpoint<"), HasSubstr(">measured<"), HasSubstr(">queue of 8<"),
                             HasSubstr(">latest, stale after 20 ms: error<"), HasSubstr(">other programs<"),
                             HasSubstr(">rt/speed<"), HasSubstr(">topic, domain 3<"),
                             HasSubstr("prefers-color-scheme: dark")));
  EXPECT_THAT(drawing,
              HasSubstr("<title>robot.trajectory.setpoint -&gt; robot.arm.setpoint: latest, best-effort, "
                        "deadline 20 ms, error when stale</title>"));
  EXPECT_EQ(occurrences(drawing, R"(class="wire)"), 6U + 2) << "six connections, and two kinds in the legend";
}

// The drawing shows a state as a word and, for a connection, also as a line style. Only these elements are
// coloured.
TEST(GraphSvg, ShowsHealthByWordsAndLineStylesNotOnlyByColour) {
  const std::string drawing = graph_svg(three(), running());
  EXPECT_THAT(drawing, AllOf(HasSubstr(R"(class="bad-word state">LOST<)"),
                             HasSubstr(R"(class="good-word state">alive<)"),
                             HasSubstr(R"(class="poor-word state">alive, belt is in RECOVER<)"),
                             HasSubstr(R"(class="bad-word state">RECOVER<)"),
                             HasSubstr(R"(class="bad-word state">LOST, was EXECUTING<)")));
  EXPECT_THAT(
      drawing,
      AllOf(HasSubstr(R"(class="good-word state">ok, 1.2 ms old<)"),
            HasSubstr(R"(class="poor-word state">degraded: loses samples, 3 ms old, lost 3, dropped 2<)"),
            HasSubstr(R"(class="bad-word state">STALE, 900 ms old, late 1<)"),
            HasSubstr(R"(class="bad-word state">NOT MATCHED<)"),
            HasSubstr(R"(class="bad-word state">NOT MATCHED: reliability<)")));
  EXPECT_THAT(drawing, AllOf(HasSubstr(R"(class="wire good")"), HasSubstr(R"(class="wire queue poor")"),
                             HasSubstr(R"(class="wire bad")"), HasSubstr(R"(class="wire queue broken")")));
  EXPECT_EQ(occurrences(drawing, "stroke-dasharray"), 3U) << "other programs, stale, not matched";
  EXPECT_THAT(drawing, AllOf(HasSubstr(">stale: the newest value"), HasSubstr(">not matched: the writer")));
  EXPECT_THAT(graph_svg(three(), {}), Not(HasSubstr(">stale: "))) << "the legend explains only what is drawn";
}

TEST(GraphSvg, ExplainsEveryRatingOnAPage) {
  const GraphPage page;
  EXPECT_THAT(graph_svg(three(), {}, &page),
              AllOf(HasSubstr(">ok<"), HasSubstr(">degraded: "), HasSubstr(">stale: "),
                    HasSubstr(">not matched: "), HasSubstr(">module: EXECUTING<"),
                    HasSubstr(">module: in a safe stop"), HasSubstr(">module: in RECOVER"),
                    HasSubstr(">module: not EXECUTING<"), HasSubstr(">bar: run time")));
}

TEST(GraphSvg, DrawsAGuideLineIfAWireLeavesOnTheSideOppositeThePortName) {
  const auto drawing = [](std::vector<model::Connection> connections) {
    return graph_svg(
        connected(cell("c", {device("a", {periodic("m", 1ms)}), device("b", {periodic("n", 1ms)}),
                             device("z", {periodic("o", 1ms)})}),
                  std::move(connections)),
        {});
  };
  const auto to_right = latest("b.n.out", "z.o.in");
  EXPECT_EQ(occurrences(drawing({to_right}), "class=\"grid\""), 0U);
  EXPECT_EQ(occurrences(drawing({to_right, latest("b.n.out", "a.m.in")}), "class=\"grid\""), 1U);
}

TEST(GraphSvg, MarksDevicesModulesAndConnectionsForTheWebPage) {
  const std::string drawing = graph_svg(three(), {});
  for (const char* mark :
       {R"(data-device="station")", R"(data-module="line.belt")", R"(data-connection="5")"})
    EXPECT_THAT(drawing, HasSubstr(mark));
  EXPECT_EQ(occurrences(drawing, "data-module="), 5U);
  EXPECT_EQ(occurrences(drawing, "data-connection="), 2 * three().connections.size())
      << "each connection has a line and words";
}

model::Cell crowd(int devices, int modules, int connections, unsigned seed) {
  std::mt19937 random{seed};
  const auto below = [&](int number) { return static_cast<int>(random() % static_cast<unsigned>(number)); };
  std::vector<model::Device> all;
  for (int d = 0; d < devices; ++d) {
    std::vector<model::Module> some;
    for (int m = 0; m < modules; ++m) some.push_back(periodic("module" + std::to_string(m), 1ms));
    all.push_back(device("device" + std::to_string(d), some));
  }
  const auto port = [&](const std::string& kind) {
    return "device" + std::to_string(below(devices)) + ".module" + std::to_string(below(modules)) + "." +
           kind + std::to_string(below(4));
  };
  std::vector<model::Connection> wires;
  for (int c = 0; c < connections; ++c) {
    auto wire =
        c % 3 == 0 ? queue(port("out"), port("in"), 8) : stale_after(latest(port("out"), port("in")), 20ms);
    if (c % 7 == 0) wire = on_topic(latest("", port("in")), "topic" + std::to_string(below(5)));
    if (c % 11 == 0) wire = on_topic(latest(port("out"), ""), "topic" + std::to_string(below(5)));
    wires.push_back(wire);
  }
  return connected(cell("crowd", all), wires);
}

CellHealth health_of(const model::Cell& cell, unsigned seed) {
  std::mt19937 random{seed};
  CellHealth health;
  for (std::size_t i = 0; i < cell.connections.size(); ++i) {
    if (random() % 4 == 0) continue;
    CellHealth::Connection& one = health.connections[i];
    one.matched = random() % 4 != 0;
    if (random() % 4 == 0) one.deadline = 20ms;
    if (random() % 2 == 0) one.age = 123ms;
    one.losing = random() % 3 == 0;
    one.lost = random() % 3 * 1000;
  }
  for (const model::Device& device : cell.devices) {
    health.devices[device.name] = {random() % 2 == 0,
                                   random() % 2 == 0 ? "some reason that is rather long" : ""};
    for (const model::Module& module : device.modules)
      health.modules[device.name + "." + module.name] = "EXECUTING";
  }
  return health;
}

/// Returns cells of many shapes, with their health: without modules, with a module without ports, with one
/// device, and with many devices.
std::vector<std::pair<model::Cell, CellHealth>> drawn() {
  std::vector<std::pair<model::Cell, CellHealth>> all{
      {cell("none", {}), {}},
      {cell("one", {device("d", {periodic("a", 1ms)})}), {}},
      {cell("empty", {device("d", {})}), {}},
      {three(), {}},
      {three(), running()},
      {connected(cell(long_name('c'), {device(long_name('d'), {periodic(long_name('m'), 1ms)})}),
                 {on_topic(latest(long_name('d') + "." + long_name('m') + "." + long_name('p'), ""),
                           std::string(255, 't'))}),
       {}},
      {crowd(60, 3, 100, 1), {}},
      {crowd(2, 120, 200, 2), {}}};
  for (unsigned seed = 0; seed < 8; ++seed) {
    const int devices = 1 + static_cast<int>(seed) % 5;
    auto cell = crowd(devices, 1 + static_cast<int>(seed) % 4, 10 * static_cast<int>(seed), seed);
    all.emplace_back(cell, CellHealth{});
    all.emplace_back(cell, health_of(cell, seed));
  }
  return all;
}

TEST(GraphSvg, IsWellFormedAndReadable) {
  for (const auto& [cell, health] : drawn()) {
    SCOPED_TRACE(cell.name + " of " + std::to_string(cell.connections.size()));
    const std::string drawing = graph_svg(cell, health);
    EXPECT_TRUE(is_well_formed(drawing));
    expect_readable(drawing);
  }
}

/// A straight segment of a wire, horizontal or vertical.
struct Piece {
  std::size_t wire = 0;
  Point from;
  Point to;

  [[nodiscard]] bool level() const { return from.y == to.y; }
  [[nodiscard]] double low() const { return level() ? std::min(from.x, to.x) : std::min(from.y, to.y); }
  [[nodiscard]] double high() const { return level() ? std::max(from.x, to.x) : std::max(from.y, to.y); }
};

std::vector<Piece> pieces_of(const graph::Layout& layout) {
  std::vector<Piece> pieces;
  for (std::size_t i = 0; i < layout.wires.size(); ++i) {
    const auto& way = layout.wires[i].way;
    for (std::size_t p = 1; p < way.size(); ++p) pieces.push_back({i, way[p - 1], way[p]});
  }
  return pieces;
}

TEST(GraphLayout, HasNoOverlappingLines) {
  for (const auto& [cell, health] : drawn()) {
    SCOPED_TRACE(cell.name + " of " + std::to_string(cell.connections.size()));
    for (const GraphPage& page : {GraphPage{}, GraphPage{{"robot", "device0", "device2"}}}) {
      const auto layout = graph::lay_out(cell, health, &page);
      const auto pieces = pieces_of(layout);
      for (const Piece& a : pieces) {
        ASSERT_TRUE(a.from.x == a.to.x || a.from.y == a.to.y);
        for (const Piece& b : pieces) {
          if (a.wire >= b.wire || a.level() != b.level()) continue;
          const graph::WireEnd& from = layout.wires[a.wire].from;
          const graph::WireEnd& other = layout.wires[b.wire].from;
          // The wires of one output leave it on one line.
          const bool of_one_output = std::tie(from.column, from.box, from.port, from.at_right) ==
                                     std::tie(other.column, other.box, other.port, other.at_right);
          if (of_one_output && a.from.y == from.y && b.from.y == from.y) continue;
          const double apart = a.level() ? std::abs(a.from.y - b.from.y) : std::abs(a.from.x - b.from.x);
          const bool beside = a.low() < b.high() && b.low() < a.high();
          ASSERT_FALSE(beside && apart < 7) << "wires " << a.wire << " and " << b.wire;
        }
      }
    }
  }
}

TEST(GraphLayout, RoutesWiresAroundBoxes) {
  for (const auto& [cell, health] : drawn()) {
    SCOPED_TRACE(cell.name + " of " + std::to_string(cell.connections.size()));
    const auto layout = graph::lay_out(cell, health);
    const auto box_of = [&](const graph::WireEnd& place) {
      return layout.columns[place.column].boxes[place.box];
    };
    for (const graph::Wire& wire : layout.wires) {
      const model::Connection& connection = cell.connections[wire.connections.front()];
      for (const auto& [place, point, end, input] :
           {std::tuple{wire.from, wire.way.front(), connection.from, false},
            std::tuple{wire.to, wire.way.back(), connection.to, true}}) {
        const graph::Column& column = layout.columns[place.column];
        const graph::Box box = box_of(place);
        EXPECT_EQ(point.x, place.at_right ? column.right() - graph::kInside : column.left + graph::kInside);
        EXPECT_GT(point.y, box.top + (place.at_right ? 0 : 30)) << "the name of the box is at the left";
        EXPECT_LT(point.y, box.top + box.height);
        EXPECT_EQ(box.ports[place.port].input, input);
        if (!end.given()) continue;
        EXPECT_EQ(column.name + "." + box.name + "." + box.ports[place.port].name, to_text(end));
      }
    }
    for (const Piece& piece : pieces_of(layout)) {
      for (const graph::Column& column : layout.columns) {
        // Only the first and the last segment of a wire may be inside a column, and only between the frame of
        // the column and a box.
        const double left = column.left + graph::kInside;
        const double right = column.right() - graph::kInside;
        const auto [x1, x2] = std::minmax(piece.from.x, piece.to.x);
        const auto [y1, y2] = std::minmax(piece.from.y, piece.to.y);
        ASSERT_FALSE(x1 < right && x2 > left && y1 < column.bottom && y2 > column.top)
            << "wire " << piece.wire;
      }
    }
    for (std::size_t c = 1; c < layout.columns.size(); ++c)
      EXPECT_GT(layout.columns[c].left, layout.columns[c - 1].right());
  }
}

TEST(GraphLayout, PutsPortsOnTheRightBesideTheFactsOfTheModule) {
  const GraphPage page;
  for (const GraphPage* on : {static_cast<const GraphPage*>(nullptr), &page}) {
    const auto layout = graph::lay_out(three(), running(), on);
    const graph::Box& box = layout.columns.front().boxes.front();
    ASSERT_EQ(box.ports.size(), 2U);
    EXPECT_EQ(box.ports[0].y, box.top + layout.pitch / 2);
    EXPECT_EQ(box.ports[1].y, box.ports[0].y + layout.pitch);
  }
}

TEST(GraphSvg, HasRoomForMeasurementsOnAPage) {
  const GraphPage page;
  const std::string drawing = graph_svg(three(), running(), &page);
  for (const char* what : {"faint run", "faint jitter", "track", "trend"})
    EXPECT_EQ(occurrences(drawing, std::string{"class=\""} + what + "\""), 4U) << what << " of four modules";
  EXPECT_THAT(graph_svg(three(), running()), Not(HasSubstr("class=\"trend\"")));
  EXPECT_TRUE(is_well_formed(drawing));
}

TEST(GraphSvg, DrawsACollapsedDeviceAsOneBoxWithBundledConnections) {
  auto cell = three();
  cell.connections.push_back(latest("robot.arm.force", "line.belt.force"));
  const GraphPage page{.collapsed = {"robot", "line"}};
  const std::string drawing = graph_svg(cell, running(), &page);
  EXPECT_EQ(occurrences(drawing, "data-module="), 1U) << "the dispatcher of the station";
  EXPECT_EQ(occurrences(drawing, "data-fold="), 3U);
  EXPECT_THAT(drawing, AllOf(HasSubstr(R"(data-connection="3 6")"), HasSubstr(">2 connections<"),
                             HasSubstr(">to line<"), HasSubstr(">from robot<")));
  EXPECT_THAT(drawing, Not(HasSubstr(R"(data-connection="0")"))) << "it is within the robot";
  EXPECT_TRUE(is_well_formed(drawing));
  expect_readable(drawing);
}

TEST(GraphLayout, DrawsTheConnectionsOfAnOutputOnOneLineUntilTheyPart) {
  const auto layout = graph::lay_out(
      connected(cells::cell("c", {device("d", {periodic("a", 1ms), periodic("b", 1ms), periodic("c", 1ms)})}),
                {latest("d.a.out", "d.b.in"), latest("d.a.out", "d.c.in")}),
      {});
  EXPECT_EQ(layout.wires[0].from.y, layout.wires[1].from.y);
  EXPECT_NE(layout.wires[0].branches, layout.wires[1].branches) << "a dot at the first corner";
}

TEST(GraphSvg, SaysHowManyElementsAreNotDrawn) {
  EXPECT_THAT(graph_svg(crowd(60, 1, 0, 1), {}), HasSubstr("only 50 of 60 devices are drawn"));
  EXPECT_THAT(graph_svg(crowd(1, 120, 0, 1), {}), HasSubstr(">and 20 modules more<"));
  EXPECT_THAT(graph_svg(crowd(2, 2, 600, 1), {}), HasSubstr(">100 of 600 connections are not drawn"));
  const auto beyond = connected(crowd(60, 1, 0, 1), {latest("device0.module0.out", "device55.module0.in")});
  EXPECT_THAT(graph_svg(beyond, {}), HasSubstr(">1 of 1 connection are not drawn"));
  EXPECT_THAT(graph_svg(three(), {}), Not(HasSubstr("drawn")));
}

TEST(GraphSvg, ContainsNoUnescapedNamesOrExternalReferences) {
  auto odd = cell("a<b>&\"c\"", {device("d", {periodic("m", 1ms)})});
  odd.connections = {on_topic(latest("d.m.o", ""), "<&\">")};
  CellHealth health;
  health.devices["d"] = {true, "</text><script>"};
  health.connections[0].incompatible = "<i>";
  const std::string drawing = graph_svg(odd, health);
  EXPECT_TRUE(is_well_formed(drawing));
  EXPECT_THAT(drawing, AllOf(HasSubstr("a&lt;b&gt;&amp;&quot;c&quot;"), Not(HasSubstr("<script")),
                             Not(HasSubstr("<i>"))));
  EXPECT_EQ(occurrences(drawing, "http"), 1U) << "the namespace";
}

}  // namespace
}  // namespace takt::tool::graph_report_test
