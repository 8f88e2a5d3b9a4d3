#include "reports/plot_report.hpp"

#include <cmath>
#include <regex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "pictures.hpp"

namespace takt::tool::plot_report_test {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

TEST(Plot, HasAxisMarksAtRoundNumbers) {
  EXPECT_THAT(ticks(0, 10, 5),
              ElementsAre(DoubleEq(0), DoubleEq(2), DoubleEq(4), DoubleEq(6), DoubleEq(8), DoubleEq(10)));
  EXPECT_THAT(ticks(-0.11, 0.26, 4),
              ElementsAre(DoubleEq(-0.1), testing::DoubleNear(0, 1e-12), DoubleEq(0.1), DoubleEq(0.2)));
  EXPECT_THAT(ticks(3, 3, 5), ElementsAre(3));
  for (const double from : {-1e300, 1e-300, 1e15, 123.456})
    for (const double to : {from + std::abs(from) * 1e-14, from + 1, 1e301})
      EXPECT_LE(ticks(from, to, 5).size(), 21U);
}

TEST(Plot, ChoosesAUnitForTheTimeAxis) {
  EXPECT_STREQ("us", unit_of_time(0.0005).name);
  EXPECT_STREQ("ms", unit_of_time(0.5).name);
  EXPECT_STREQ("s", unit_of_time(60).name);
  EXPECT_STREQ("min", unit_of_time(3600).name);
  EXPECT_STREQ("h", unit_of_time(86400).name);
}

TEST(Plot, LeavesAGapInACurveWhereSamplesAreMissing) {
  Plot plot{.title = "cell", .subtitle = "x", .from = 0, .to = 10};
  plot.panels.push_back({.title = "speed",
                         .series = {{.name = "a.b.c.speed & <more>",
                                     .curves = {{{0, 1}, {4, 2}}, {{6, 2}, {9, 3}}, {{10, 1}}}}}});
  plot.panels.push_back({.title = "mode",
                         .series = {{.name = "a.b.c.mode", .curves = {{{0, 0}, {5, 1}, {10, 0}}}}},
                         .labels = {"OFF", "RUNS"}});
  const std::string svg = plot_svg(plot);
  const auto count = [&](const std::string& what) {
    std::size_t n = 0;
    for (auto at = svg.find(what); at != std::string::npos; at = svg.find(what, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(3U, count("class=\"curve"));  // two curves of the first series, one of the second
  EXPECT_EQ(1U, count("<circle"));
  EXPECT_THAT(svg, HasSubstr("a.b.c.speed &amp; &lt;more&gt;"));
  EXPECT_THAT(svg, HasSubstr(">RUNS<"));
  EXPECT_THAT(svg, HasSubstr("time in s"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

Plot plot_of(std::vector<PlotPoint> points) {
  Plot plot{.title = "t", .subtitle = "", .from = points.front().time, .to = points.back().time};
  plot.panels.push_back({.title = "p", .series = {{.name = "s", .curves = {std::move(points)}}}});
  return plot;
}

/// Returns the labels of the value axis, from bottom to top.
std::vector<std::string> value_marks(const std::string& svg) {
  static const std::regex kMark{R"re(text-anchor="end" class="faint">([^<]*)<)re"};
  std::vector<std::string> found;
  for (std::sregex_iterator at{svg.begin(), svg.end(), kMark}, end; at != end; ++at)
    found.push_back((*at)[1]);
  return found;
}

TEST(Plot, LabelsLargeNumbersDistinctly) {
  for (const auto& [low, high] : {std::pair{-1234568.0, -1234566.5}, {1e6, 1e6 + 2e-3}, {1e-9, 4e-9}}) {
    const std::string svg = plot_svg(plot_of({{0, low}, {10, high}}));
    const auto marks = value_marks(svg);
    EXPECT_GE(marks.size(), 3U);
    EXPECT_EQ(marks.size(), std::set(marks.begin(), marks.end()).size()) << testing::PrintToString(marks);
    drawings::expect_readable(svg);
  }
  const double month = 30 * 86400.0;
  const std::string late = plot_svg(plot_of({{month, 1}, {month + 1e-3, 2}}));
  EXPECT_THAT(late, HasSubstr(">2592000000.2<"));
  drawings::expect_readable(late);
}

TEST(Plot, ShowsTheTimeOfASingleSample) {
  const std::string svg = plot_svg(plot_of({{3, 1.5}}));
  EXPECT_THAT(svg, HasSubstr("time in s<"));
  EXPECT_THAT(svg, HasSubstr(">3<"));
}

TEST(Plot, MarksOnlyWholeNumbersIfAllValuesAreWhole) {
  EXPECT_THAT(value_marks(plot_svg(plot_of({{0, 1}, {5, 2}, {10, 3}}))), ElementsAre("1", "2", "3"));
  EXPECT_THAT(value_marks(plot_svg(plot_of({{0, 7}, {10, 7}}))), ElementsAre("7"));
  EXPECT_THAT(value_marks(plot_svg(plot_of({{0, 1}, {5, 2.5}}))), testing::Contains("1.5"));
}

std::size_t shapes(const Plot& plot) {
  const std::string svg = plot_svg(plot);
  drawings::expect_readable(svg);
  return drawings::occurrences(svg, "<circle") + drawings::occurrences(svg, "z\" class=\"d");
}

TEST(Plot, MarksEachOfSeveralCurvesWithItsOwnShape) {
  Plot plot = plot_of({{0, 1}, {10, 2}});
  EXPECT_EQ(shapes(plot), 0U) << "a single curve needs no shape";
  PlotSeries same = plot.panels[0].series[0];
  same.name = "t";
  same.curves.push_back({{10, 1}});
  plot.panels[0].series.insert(plot.panels[0].series.end(), {same, same});
  // The curves of different series have different shapes: circles, squares and triangles. The shapes mark
  // curves, single samples and entries of the legend.
  const std::string svg = plot_svg(plot);
  EXPECT_EQ(drawings::occurrences(svg, "<circle"), 10U + 1U);
  EXPECT_EQ(drawings::occurrences(svg, "z\" class=\"d2\""), 10U + 1U + 1U);
  EXPECT_EQ(shapes(plot), 11U + 12U);
}

TEST(Plot, HasAxisMarksEvenForTheLargestNumbers) {
  const auto marks = value_marks(plot_svg(plot_of({{0, 0}, {10, 1e308}})));
  EXPECT_THAT(marks, testing::Contains("1e+308"));
}

TEST(Plot, NeverContainsNanOrInf) {
  for (const double value : {0.0, 1e308, -1e308, 1e-320}) {
    Plot plot{.title = "t", .subtitle = "", .from = 0, .to = 0};
    plot.panels.push_back(
        {.title = "p", .series = {{.name = "s", .curves = {{{0, value}, {0, value}, {0, -value}}}}}});
    const std::string svg = plot_svg(plot);
    EXPECT_THAT(svg, Not(HasSubstr("nan"))) << value;
    EXPECT_THAT(svg, Not(HasSubstr("inf"))) << value;
  }
}

}  // namespace
}  // namespace takt::tool::plot_report_test
