#include "check_report.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
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

TEST(CheckText, KeepsRowsApartThatOnlyHaveAsManyModules) {
  EXPECT_THAT(text(cell("c", {device("d", {periodic("a", 2ms), periodic("b", 3ms)})})),
              HasSubstr("    2    2 ms    a\n    3    3 ms    b\n    4    4 ms    a\n    5    5 ms    -\n"));
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

// ---- as a picture

std::string svg(const model::Cell& cell) { return check_svg(cell, plans(cell)); }

std::size_t occurrences(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

/// All that a picture shows of a text: where it is and how far it reaches in a wide font.
struct Label {
  double left = 0;
  double right = 0;
  double baseline = 0;
  double size = 0;
  std::string words;
};

std::vector<Label> labels(const std::string& picture) {
  static const std::regex kText{
      R"re(<text x="([-0-9.]+)" y="([-0-9.]+)" font-size="([0-9.]+)" text-anchor="(\w+)" class="[^"]*">([^<]*)</text>)re"};
  std::vector<Label> found;
  for (std::sregex_iterator at{picture.begin(), picture.end(), kText}, end; at != end; ++at) {
    Label label{.baseline = std::stod((*at)[2]), .size = std::stod((*at)[3]), .words = (*at)[5]};
    const double width = static_cast<double>(label.words.size()) * label.size * 0.61;
    label.left = std::stod((*at)[1]) - ((*at)[4] == "middle" ? width / 2 : 0);
    label.right = label.left + width;
    found.push_back(std::move(label));
  }
  return found;
}

bool overlap(const Label& a, const Label& b) {
  return a.left < b.right && b.left < a.right && a.baseline - 0.75 * a.size < b.baseline + 0.2 * b.size &&
         b.baseline - 0.75 * b.size < a.baseline + 0.2 * a.size;
}

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

class Picture : public testing::TestWithParam<int> {
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

TEST_P(Picture, IsWellFormed) {
  const auto file = std::filesystem::path{testing::TempDir()} /
                    ("takt_check_" + std::to_string(::getpid()) + "_" + std::to_string(GetParam()) + ".svg");
  std::ofstream{file} << svg(drawn());
  EXPECT_EQ(std::system(("xmllint --noout " + file.string()).c_str()), 0);
  std::filesystem::remove(file);
}

TEST_P(Picture, CutsNoTextOffAndPutsNoneOnAnother) {
  const std::string picture = svg(drawn());
  std::smatch box;
  ASSERT_TRUE(std::regex_search(picture, box, std::regex{R"re(viewBox="0 0 (\d+) (\d+)")re"}));
  const auto all = labels(picture);
  ASSERT_EQ(all.size(), occurrences(picture, "<text "));
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_GE(all[i].left, 0) << all[i].words;
    EXPECT_LE(all[i].right, std::stod(box[1])) << all[i].words;
    EXPECT_LE(all[i].baseline, std::stod(box[2])) << all[i].words;
    for (std::size_t j = i + 1; j < all.size(); ++j) {
      EXPECT_FALSE(overlap(all[i], all[j])) << all[i].words << " and " << all[j].words;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(CheckSvg, Picture, testing::Range(0, 6));

TEST(CheckSvg, NumbersEachReleaseByItsPlaceInTheRow) {
  const std::string picture = svg(figure1());
  EXPECT_EQ(occurrences(picture, R"(class="on">1</text>)"), 6U + 1);  // and one in the legend
  EXPECT_EQ(occurrences(picture, R"(class="on">2</text>)"), 6U + 1);
  EXPECT_EQ(occurrences(picture, R"(class="on">3</text>)"), 2U);
  EXPECT_EQ(occurrences(picture, R"(class="on">4</text>)"), 1U);
}

TEST(CheckSvg, ShowsPeriodsModulesAndDeadlines) {
  EXPECT_THAT(
      svg(figure1()),
      AllOf(
          HasSubstr("basic period 100 us, macro period 600 us, 6 rows; any cpu, priority 80, wakeup hybrid"),
          HasSubstr(">controller1<"), HasSubstr("thread, every 600 us, priority 3"),
          HasSubstr("process, deadline 10 ms, priority 2"), HasSubstr(">600 us<"),
          HasSubstr("not real-time: monitoring (process)"), HasSubstr("no budgets are stated"),
          HasSubstr("prefers-color-scheme: dark")));
}

TEST(CheckSvg, DrawsBudgetsToTheScaleOfTime) {
  // One row of 240: the second thread begins where the first has used its budget, the process at the release.
  const std::string picture = svg(cell(
      "c", {device("d", {with_budget(periodic("a", 1ms, 1), 250us), with_budget(periodic("b", 1ms, 2), 500us),
                         process(with_budget(periodic("p", 1ms, 3), 750us))})}));
  const std::regex bar{
      R"re(<rect x="([0-9.]+)" y="[0-9.]+" width="([0-9.]+)" height="6.0" rx="0" class="(\w+)-budget")re"};
  std::vector<std::array<double, 2>> bars;
  for (std::sregex_iterator at{picture.begin(), picture.end(), bar}, end; at != end; ++at) {
    bars.push_back({std::stod((*at)[1]), std::stod((*at)[2])});
  }
  ASSERT_EQ(bars.size(), 3U);
  EXPECT_NEAR(bars[0][1], 60, 0.2);
  EXPECT_NEAR(bars[1][0], bars[0][0] + 60, 0.2);
  EXPECT_NEAR(bars[1][1], 120, 0.2);
  EXPECT_NEAR(bars[2][0], bars[0][0], 0.2);
  EXPECT_NEAR(bars[2][1], 180, 0.2);
  EXPECT_THAT(picture, HasSubstr(">75%<"));
}

TEST(CheckSvg, SaysWhatItLeavesOut) {
  EXPECT_THAT(svg(cell("long", {device("d", {periodic("a", 2ms), periodic("b", 7919ms)})})),
              HasSubstr("only rows 0 to 63 of 15838 are drawn"));
  EXPECT_THAT(svg(crowded_cell()),
              AllOf(HasSubstr("and 51 more periodic modules"), HasSubstr("and 50 more sporadic modules")));
  EXPECT_THAT(svg(figure1()), Not(HasSubstr("are drawn")));
}

TEST(CheckSvg, EscapesNames) {
  EXPECT_THAT(svg(cell("a<b>&\"c\"", {})),
              AllOf(HasSubstr("a&lt;b&gt;&amp;&quot;c&quot;"), Not(HasSubstr("a<b>"))));
}

TEST(CheckSvg, NeedsNothingFromElsewhere) {
  const std::string picture = svg(palletizing());
  EXPECT_EQ(occurrences(picture, "http"), 1U) << "the namespace";
  EXPECT_THAT(picture, AllOf(Not(HasSubstr("href")), Not(HasSubstr("@import")), Not(HasSubstr("<script"))));
}

}  // namespace
}  // namespace takt::tool
