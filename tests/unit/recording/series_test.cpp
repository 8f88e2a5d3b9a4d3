#include <takt/recording/series.hpp>

#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::recording::series_test {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

std::size_t points(const Series& series) {
  std::size_t count = 0;
  for (const auto& curve : series.curves()) count += curve.size();
  return count;
}

TEST(Series, ReducesAMillionSamplesWithoutLosingAPeak) {
  constexpr std::int64_t kSamples = 1'000'000;
  Series series{{0, kSamples - 1}, 900, kNever};
  // Two of the samples are peaks, one upwards and one downwards.
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

TEST(Series, KeepsEverySampleOfASmallSet) {
  Series series{{0, 100}, 900, kNever};
  for (int i = 0; i <= 10; ++i) series.add(i * 10, i);
  ASSERT_EQ(11U, points(series));
  EXPECT_EQ(5, series.mean());
}

TEST(Series, BeginsANewCurveAfterALongPause) {
  Series series{{0, 1000}, 10, 50};
  for (const std::int64_t time : {0, 20, 40, 91, 110, 600}) series.add(time, 1);
  const auto curves = series.curves();
  ASSERT_EQ(3U, curves.size());
  EXPECT_EQ(40, curves[0].back().time_ns);
  EXPECT_EQ(91, curves[1].front().time_ns);
  EXPECT_EQ(1U, curves[2].size());
}

TEST(Series, BeginsANewCurveAfterLostSamplesIfTheGapIsVisible) {
  Series series{{0, 1000}, 10, kNever};
  series.add(0, 1);
  series.add(150, 1, true);  // in the next column
  series.add(399, 1, true);
  series.add(590, 1);
  series.add(599, 1, true);
  const auto curves = series.curves();
  ASSERT_EQ(2U, curves.size());
  EXPECT_EQ(150, curves[0].back().time_ns);
  EXPECT_EQ(399, curves[1].front().time_ns);
}

TEST(Series, IgnoresSamplesThatAreOutOfOrderOrNotFinite) {
  Series series{{0, 100}, 100, kNever};
  series.add(10, 1);
  series.add(20, std::nan(""));
  series.add(30, std::numeric_limits<double>::infinity());
  series.add(5, 2);
  series.add(40, 3);
  EXPECT_EQ(2U, series.count());
  EXPECT_EQ(3, series.largest());
}

TEST(Series, TreatsTenTimesTheMedianIntervalAsAPause) {
  EXPECT_EQ(100, longest_pause({0, 10, 20, 30, 400, 410, 420}, 0));
  EXPECT_EQ(5000, longest_pause({0, 10, 20, 30, 400, 410, 420}, 5000));
  EXPECT_GT(longest_pause({0, 1'000'000'000}, 0), 1'000'000'000'000);
}

}  // namespace
}  // namespace takt::recording::series_test
