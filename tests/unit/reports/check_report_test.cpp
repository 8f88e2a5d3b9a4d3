#include "check_report.hpp"

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cells.hpp"

namespace takt::tool {
namespace {

using namespace cells;
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

/// All that is long at once: names, times, priorities, tables, lists.
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
  return cell(long_name('c'), {result});
}

// ---- for a person

TEST(CheckText, ShowsFigure3WithEqualRowsInOneLine) {
  EXPECT_THAT(text(figure1()), HasSubstr(R"(
    basic period 100 us, macro period 600 us, 6 rows, 15 entries

    row  offset  modules, in the order in which they run
    0    0 ns    control3, control2, controller1, control4 (process)
    1-2  100 us  control3, control2
    3    300 us  control3, control2, control4 (process)
    4-5  400 us  control3, control2
)"));
}

TEST(CheckText, ShowsFigure4WithDeadlines) {
  EXPECT_THAT(text(figure1()), HasSubstr(R"(
    sporadic   type     deadline  priority  budget
    emergency  thread   100 us    1         -
    vision     process  10 ms     2         -
)"));
}

TEST(CheckText, NamesWhatIsNotRealTimeAndTheExecutor) {
  EXPECT_THAT(text(figure1()), AllOf(HasSubstr("cell module: 1 device, 7 modules"),
                                     HasSubstr("executor main: any cpu, priority 80, wakeup hybrid"),
                                     HasSubstr("not real-time: monitoring (process)")));
}

TEST(CheckText, PredictsTheLoadFromBudgets) {
  const std::string all = text(cell(
      "c", {device("d", {with_budget(periodic("a", 1ms), 300us), with_budget(periodic("b", 2ms), 200us)})}));
  EXPECT_THAT(
      all, AllOf(HasSubstr("row 0 is the fullest with 500 us of 1 ms (50 %); 40.0 % over the macro period"),
                 HasSubstr("0    0 ns    50 %  a, b\n"), HasSubstr("1    1 ms    30 %  a\n"),
                 Not(HasSubstr("without a budget"))));
}

TEST(CheckText, SaysWhichModulesMakeTheLoadUncertain) {
  const std::string some = text(cell("c", {device("d", {with_budget(periodic("a", 1ms), 300us),
                                                        periodic("b", 2ms), process(periodic("p", 1ms))})}));
  EXPECT_THAT(some, AllOf(HasSubstr("predicted load, at least:"), HasSubstr(">= 30 %"),
                          HasSubstr("without a budget: b\n")));
  const std::string none = text(cell("c", {device("d", {periodic("a", 1ms)})}));
  EXPECT_THAT(none, AllOf(HasSubstr("load not predicted, without a budget: a\n"), Not(HasSubstr(" % "))));
}

TEST(CheckText, WarnsOfADeadlineThatPassesBetweenTwoLooks) {
  const std::string late = text(cell("c", {device("d", {periodic("a", 10ms), sporadic("alarm", 1ms)})}));
  EXPECT_THAT(late, HasSubstr("late by design, looked at only once in 10 ms:\n      alarm\n"));
  EXPECT_THAT(text(figure1()), Not(HasSubstr("late by design")));
}

TEST(CheckText, ShowsExecutorsWithoutPeriodicModulesAndWithoutAny) {
  EXPECT_THAT(text(palletizing()),
              AllOf(HasSubstr("basic period 4 ms, half the shortest deadline"),
                    HasSubstr("executor spare: any cpu, priority 80, wakeup hybrid\n    no modules\n")));
}

TEST(CheckText, ShowsTheBeginningOfALongTableAndCountsTheRest) {
  // No two neighbours are equal: 2 ms and 3 ms modules among 7919 rows.
  const std::string all = text(cell("c", {device("d", {periodic("a", 2ms), periodic("b", 7919ms)})}));
  EXPECT_THAT(all, AllOf(HasSubstr("39   39 ms"), Not(HasSubstr("\n    40 ")),
                         HasSubstr("... and 15798 rows more; --json has them all")));
}

TEST(CheckText, NamesTheFirstOfVeryManyModules) {
  std::vector<model::Module> modules;
  for (int i = 0; i < 1000; ++i) modules.push_back(periodic("m" + std::to_string(i), 1ms));
  for (int i = 0; i < 100; ++i) modules.push_back(sporadic("s" + std::to_string(i), 1ms));
  const std::string all = text(cell("c", {device("d", modules)}));
  EXPECT_THAT(all, AllOf(HasSubstr("m31, and 968 more"), HasSubstr("s39 "), Not(HasSubstr("s40")),
                         HasSubstr("... and 60 more")));
}

TEST(CheckText, IsNeverWiderThanItsColumns) {
  for (const model::Cell& cell : {figure1(), palletizing(), widest_cell()}) {
    EXPECT_LE(widest(text(cell, {.width = 100})), 100U) << text(cell);
    EXPECT_LE(widest(text(cell, {.width = 80})), 80U) << text(cell, {.width = 80});
    EXPECT_LE(widest(text(cell, {.width = 1000})), 100U);
    EXPECT_LE(widest(text(cell, {.width = 0})), 80U);
  }
}

TEST(CheckText, HasEscapesOnlyInColourAndNothingElseChanges) {
  const std::string plain = text(palletizing());
  std::string coloured = text(palletizing(), {.colour = true});
  EXPECT_EQ(plain.find('\x1b'), std::string::npos);
  ASSERT_NE(coloured.find('\x1b'), std::string::npos);
  for (std::size_t at = 0; (at = coloured.find('\x1b')) != std::string::npos;) {
    coloured.erase(at, coloured.find('m', at) - at + 1);
  }
  EXPECT_EQ(coloured, plain);
}

TEST(CheckText, LeavesNoBlanksAtTheEndsOfLines) {
  for (const std::string& line :
       lines(text(palletizing()) + text(widest_cell()) + text(widest_cell(), {.width = 80}))) {
    EXPECT_TRUE(line.empty() || line.back() != ' ') << line;
  }
}

// ---- for a program

TEST(CheckJson, IsTheContractForFigure1) {
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

TEST(CheckJson, HasArraysEvenWhereThereIsNothing) {
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

TEST(CheckJson, HasEveryRowOfALongTable) {
  const model::Cell cell = cells::cell("c", {device("d", {periodic("a", 1us), periodic("b", 100ms)})});
  EXPECT_EQ(check_json(cell, plans(cell))["devices"][0]["executors"][0]["rows"].size(), 100'000U);
}

}  // namespace
}  // namespace takt::tool
