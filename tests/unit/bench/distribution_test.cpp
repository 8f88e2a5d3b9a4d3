#include "distribution.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace takt::bench::distribution_test {
namespace {

TEST(Distribution, IsZeroWithoutValues) {
  const Distribution d = distribution_of({});
  EXPECT_EQ(0U, d.count);
  EXPECT_EQ(0, d.mean);
  EXPECT_EQ(0, d.p99);
  EXPECT_EQ(0, d.max);
}

TEST(Distribution, OfASingleValueHasPercentilesEqualToItsMagnitude) {
  const Distribution d = distribution_of({-7});
  EXPECT_EQ(1U, d.count);
  EXPECT_EQ(-7, d.mean);
  EXPECT_EQ(0, d.variance);
  for (const double size : {d.min, d.p50, d.p90, d.p99, d.p999, d.max}) EXPECT_EQ(7, size);
}

TEST(Distribution, ComputesPercentilesByNearestRank) {
  std::vector<std::int64_t> values(1000);
  std::iota(values.rbegin(), values.rend(), 1);
  const Distribution d = distribution_of(values);
  EXPECT_EQ(1, d.min);
  EXPECT_EQ(500, d.p50);
  EXPECT_EQ(900, d.p90);
  EXPECT_EQ(990, d.p99);
  EXPECT_EQ(999, d.p999);
  EXPECT_EQ(1000, d.max);
}

TEST(Distribution, UsesAbsoluteValuesExceptForMeanAndVariance) {
  const Distribution d = distribution_of({-3, 3, -1, 1});
  EXPECT_EQ(0, d.mean);
  EXPECT_EQ(5, d.variance);
  EXPECT_EQ(1, d.min);
  EXPECT_EQ(1, d.p50);
  EXPECT_EQ(3, d.max);
}

TEST(Distribution, ComputesASmallVarianceOfLargeValuesExactly) {
  const std::int64_t far = 1'000'000'000'000;
  EXPECT_EQ(1, distribution_of({far - 1, far + 1}).variance);
}

TEST(Percentile, IsAlwaysOneOfTheValues) {
  const std::vector<std::int64_t> sizes{10, 20};
  EXPECT_EQ(10, percentile(sizes, 0));
  EXPECT_EQ(10, percentile(sizes, 0.5));
  EXPECT_EQ(20, percentile(sizes, 0.51));
  EXPECT_EQ(20, percentile(sizes, 1));
}

}  // namespace
}  // namespace takt::bench::distribution_test
