#include <takt/core/statistics.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>
#include <thread>
#include <vector>

namespace takt::statistics_test {
namespace {

TEST(HistogramScale, PutsEachValueIntoTheBucketOfItsRange) {
  for (int shift = 0; shift < 39; ++shift) {
    for (std::int64_t delta = -1; delta <= 1; ++delta) {
      const std::int64_t value = (std::int64_t{1} << shift) + delta;
      const std::size_t bucket = HistogramScale::bucket(value);
      EXPECT_LE(HistogramScale::lower(bucket), value);
      EXPECT_GT(HistogramScale::lower(bucket + 1), value);
    }
  }
  EXPECT_EQ(HistogramScale::bucket(-5), 0U);
  EXPECT_EQ(HistogramScale::bucket(std::int64_t{1} << 60), HistogramScale::kBuckets - 1);
}

TEST(Statistics, AreAllZeroWithoutValues) {
  const StatisticsSnapshot s = std::make_unique<Statistics>()->read();
  EXPECT_EQ(s.count, 0U);
  EXPECT_EQ(s.mean, 0);
  EXPECT_EQ(s.variance, 0);
  EXPECT_EQ(s.quantile(0.99), 0);
}

TEST(Statistics, UsesAbsoluteValuesExceptForMeanAndVariance) {
  auto statistics = std::make_unique<Statistics>();
  statistics->record(-300);
  statistics->record(100);
  const StatisticsSnapshot s = statistics->read();
  EXPECT_EQ(s.count, 2U);
  EXPECT_DOUBLE_EQ(s.mean, -100);
  EXPECT_DOUBLE_EQ(s.variance, 40000);
  EXPECT_EQ(s.min, 100);
  EXPECT_EQ(s.max, 300);
}

TEST(Statistics, MatchesValuesComputedFromAllSamples) {
  std::mt19937_64 random{7};
  std::lognormal_distribution<double> draw{8, 2};
  auto statistics = std::make_unique<Statistics>();
  std::vector<std::int64_t> values(100'000);
  double sum = 0;
  double squares = 0;
  for (auto& value : values) {
    value = static_cast<std::int64_t>(draw(random));
    statistics->record(value);
    sum += static_cast<double>(value);
    squares += static_cast<double>(value) * static_cast<double>(value);
  }
  std::sort(values.begin(), values.end());
  const StatisticsSnapshot s = statistics->read();
  const auto n = static_cast<double>(values.size());
  EXPECT_NEAR(s.mean, sum / n, 1e-6 * sum / n);
  EXPECT_NEAR(s.variance, squares / n - (sum / n) * (sum / n), 1e-6 * squares / n);
  EXPECT_EQ(s.min, values.front());
  EXPECT_EQ(s.max, values.back());
  for (double q : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const auto exact = static_cast<double>(values[static_cast<std::size_t>(q * n)]);
    EXPECT_NEAR(s.quantile(q), exact, 0.065 * exact + 1) << q;
  }
}

TEST(Statistics, GivesAConsistentSnapshotDuringWrites) {
  auto statistics = std::make_unique<Statistics>();
  std::atomic<bool> end{false};
  // Every recorded value is 1000, so a mixture of two states would show in the mean or in the buckets. A real
  // module records a few values in 100 us. This writer records more often, but leaves the reader enough time
  // to read all statistics between two values.
  std::thread writer{[&] {
    while (!end) {
      statistics->record(1000);
      for (int i = 0; i < 100000; ++i) std::atomic_signal_fence(std::memory_order_seq_cst);
    }
  }};
  const std::size_t bucket = HistogramScale::bucket(1000);
  std::uint64_t last = 0;
  std::set<std::uint64_t> mixed;  // the counts of inconsistent snapshots
  while (last < 500) {
    const StatisticsSnapshot s = statistics->read();
    if (s.count == 0) continue;
    if (s.mean != 1000 || s.buckets[bucket] != s.count) mixed.insert(s.count);
    EXPECT_GE(s.count, last);
    last = s.count;
  }
  end = true;
  writer.join();
  // If the writer loses its CPU while it records a value, read() treats it as dead. This is rare.
  EXPECT_LE(mixed.size(), 5U);
}

TEST(Statistics, CanBeReadAfterTheWriterDiedWhileWriting) {
  auto statistics = std::make_unique<Statistics>();
  statistics->record(5);
  // The sequence number is the first member of the statistics. Incrementing it simulates a writer that died
  // while it was writing.
  auto* sequence = reinterpret_cast<std::atomic<std::uint64_t>*>(statistics.get());
  sequence->store(sequence->load() + 1);
  EXPECT_EQ(statistics->read().count, 1U);
  statistics->record(5);  // the writer that takes its place
  EXPECT_EQ(statistics->read().count, 2U);
  EXPECT_EQ(sequence->load() % 2, 0U) << "each read() would fail 1000 times";
}

}  // namespace
}  // namespace takt::statistics_test
