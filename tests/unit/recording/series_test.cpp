#include "recording/series.hpp"

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plot_report.hpp"

namespace takt::tool {
namespace {

using testing::DoubleEq;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

std::size_t points(const Series& series) {
  std::size_t count = 0;
  for (const auto& curve : series.curves()) count += curve.size();
  return count;
}

TEST(Series, AMillionSamplesAreFewPointsAndNoPeakIsLost) {
  constexpr std::int64_t kSamples = 1'000'000;
  Series series{{0, kSamples - 1}, 900, kNever};
  // One sample alone is up, one down, anywhere.
  for (std::int64_t i = 0; i < kSamples; ++i)
    series.add(i, i == 123'457 ? 1000 : i == 765'433 ? -1000 : std::sin(static_cast<double>(i)));
  EXPECT_EQ(static_cast<std::uint64_t>(kSamples), series.count());
  EXPECT_LE(points(series), 4U * 900U);
  const auto curves = series.curves();
  ASSERT_EQ(1U, curves.size());
  EXPECT_THAT(curves[0], testing::Contains(SeriesPoint{123'457, 1000}));
  EXPECT_THAT(curves[0], testing::Contains(SeriesPoint{765'433, -1000}));
  EXPECT_EQ((SeriesPoint{0, 0}), curves[0].front());
  EXPECT_EQ(kSamples - 1, curves[0].back().time_ns);
  for (std::size_t i = 1; i < curves[0].size(); ++i)
    ASSERT_LE(curves[0][i - 1].time_ns, curves[0][i].time_ns);
  EXPECT_EQ(-1000, series.least());
  EXPECT_EQ(1000, series.largest());
}

TEST(Series, KeepsEverySampleWhereThereAreFew) {
  Series series{{0, 100}, 900, kNever};
  for (int i = 0; i <= 10; ++i) series.add(i * 10, i);
  ASSERT_EQ(11U, points(series));
  EXPECT_EQ(5, series.mean());
}

TEST(Series, BeginsAnewAfterAPause) {
  Series series{{0, 1000}, 10, 50};
  for (const std::int64_t time : {0, 20, 40, 91, 110, 600}) series.add(time, 1);
  const auto curves = series.curves();
  ASSERT_EQ(3U, curves.size());
  EXPECT_EQ(40, curves[0].back().time_ns);
  EXPECT_EQ(91, curves[1].front().time_ns);
  EXPECT_EQ(1U, curves[2].size());
}

TEST(Series, LeavesOutWhatIsNoNumberAndWhatIsEarlier) {
  Series series{{0, 100}, 100, kNever};
  series.add(10, 1);
  series.add(20, std::nan(""));
  series.add(30, std::numeric_limits<double>::infinity());
  series.add(5, 2);
  series.add(40, 3);
  EXPECT_EQ(2U, series.count());
  EXPECT_EQ(3, series.largest());
}

TEST(Series, ALongPauseIsTenTimesTheUsual) {
  EXPECT_EQ(100, longest_pause({0, 10, 20, 30, 400, 410, 420}, 0));
  EXPECT_EQ(5000, longest_pause({0, 10, 20, 30, 400, 410, 420}, 5000));
  EXPECT_GT(longest_pause({0, 1'000'000'000}, 0), 1'000'000'000'000);
}

TEST(Plot, MarksAreRoundNumbers) {
  EXPECT_THAT(ticks(0, 10, 5),
              ElementsAre(DoubleEq(0), DoubleEq(2), DoubleEq(4), DoubleEq(6), DoubleEq(8), DoubleEq(10)));
  EXPECT_THAT(ticks(-0.11, 0.26, 4),
              ElementsAre(DoubleEq(-0.1), testing::DoubleNear(0, 1e-12), DoubleEq(0.1), DoubleEq(0.2)));
  EXPECT_THAT(ticks(3, 3, 5), ElementsAre(3));
  for (const double from : {-1e300, 1e-300, 1e15, 123.456})
    for (const double to : {from + std::abs(from) * 1e-14, from + 1, 1e301})
      EXPECT_LE(ticks(from, to, 5).size(), 21U);
}

TEST(Plot, TimeHasTheUnitThatIsReadBest) {
  EXPECT_STREQ("us", unit_of_time(0.0005).name);
  EXPECT_STREQ("ms", unit_of_time(0.5).name);
  EXPECT_STREQ("s", unit_of_time(60).name);
  EXPECT_STREQ("min", unit_of_time(3600).name);
  EXPECT_STREQ("h", unit_of_time(86400).name);
}

TEST(Plot, DrawsCurvesGapsAndNames) {
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
  EXPECT_EQ(3U, count("class=\"curve"));  // two parts of the first, one of the second
  EXPECT_EQ(1U, count("<circle"));
  EXPECT_THAT(svg, HasSubstr("a.b.c.speed &amp; &lt;more&gt;"));
  EXPECT_THAT(svg, HasSubstr(">RUNS<"));
  EXPECT_THAT(svg, HasSubstr("time in s"));
  EXPECT_THAT(svg, Not(HasSubstr("nan")));
}

TEST(Plot, HasNoNumbersThatAreNone) {
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
}  // namespace takt::tool
