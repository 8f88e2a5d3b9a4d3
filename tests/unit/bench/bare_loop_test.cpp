#include "bare_loop.hpp"

#include <gtest/gtest.h>

namespace takt::bench::bare_loop_test {
namespace {

using namespace std::chrono_literals;

const Grid kGrid{.first = from_ns(1'000'000), .period = 100us, .length = 1ms};

// Runs a loop on kGrid whose first wake-ups are late by the given delays. All later wake-ups are on time.
Loop loop_with(const std::vector<Nanoseconds>& late, std::vector<Instant>* releases = nullptr) {
  std::size_t cycle = 0;
  return loop_on_grid(
      kGrid, [&](Instant release) { return release + (cycle < late.size() ? late[cycle++] : 0ns); },
      [releases](Instant release) {
        if (releases != nullptr) releases->push_back(release);
      });
}

TEST(LoopOnGrid, RunsOneCycleAtEachInstantOfItsGrid) {
  std::vector<Instant> releases;
  const Loop loop = loop_with({}, &releases);
  EXPECT_EQ(std::vector<std::int64_t>(10, 0), loop.jitter);
  EXPECT_EQ(0U, loop.missed);
  ASSERT_EQ(10U, releases.size());
  EXPECT_EQ(kGrid.first, releases.front());
  EXPECT_EQ(kGrid.first + 9 * kGrid.period, releases.back());
}

TEST(LoopOnGrid, MeasuresJitterAsReleaseTimeMinusStartTime) {
  EXPECT_EQ(-5000, loop_with({0us, 5us}).jitter.at(1));
}

TEST(LoopOnGrid, KeepsTheGridAfterMissedInstants) {
  std::vector<Instant> releases;
  const Loop loop = loop_with({0us, 250us}, &releases);
  EXPECT_EQ(2U, loop.missed);
  ASSERT_EQ(8U, loop.jitter.size());
  // Cycle 1 wakes up 250 us late, which is 50 us after the beginning of the slot in which the cycle runs.
  EXPECT_EQ(-50'000, loop.jitter.at(1));
  EXPECT_EQ(kGrid.first + 3 * kGrid.period, releases.at(1));
  EXPECT_EQ(0, loop.jitter.at(2));
}

TEST(LoopOnGrid, EndsIfTheLastInstantsWereMissed) {
  const Loop loop = loop_with({5ms});
  EXPECT_TRUE(loop.jitter.empty());
  EXPECT_EQ(50U, loop.missed);
}

TEST(LoopOnGrid, RunsNoCycleIfItsGridIsEmpty) {
  const Grid grid{.first = from_ns(0), .period = 1ms, .length = 100us};
  EXPECT_TRUE(loop_on_grid(grid, [](Instant release) { return release; }).jitter.empty());
}

}  // namespace
}  // namespace takt::bench::bare_loop_test
