#include "rate.h"

#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <line.hpp>

namespace {

double after(double seconds, double parts_per_second) {
  counter_rate rate{};
  double per_minute = 0;
  const int steps = static_cast<int>(seconds / 0.02);
  for (int i = 1; i <= steps; ++i) {
    per_minute = counter_rate_step(&rate, static_cast<uint32_t>(i * 0.02 * parts_per_second), 0.02);
  }
  return per_minute;
}

TEST(Rate, IsZeroWithoutParts) { EXPECT_EQ(after(10, 0), 0); }
TEST(Rate, IsExtrapolatedDuringTheFirstMinute) { EXPECT_NEAR(after(10, 2), 120, 6); }
TEST(Rate, CoversOnlyTheLastMinute) { EXPECT_NEAR(after(300, 0.5), 30, 1); }

TEST(Rate, ForgetsPartsOlderThanAMinute) {
  counter_rate rate{};
  counter_rate_step(&rate, 100, 0.02);
  double per_minute = 0;
  for (int i = 0; i < 61 * 50; ++i) per_minute = counter_rate_step(&rate, 100, 0.02);
  EXPECT_EQ(per_minute, 0);
}

TEST(Rate, DoesNotRiseWhenThePartCountRestarts) {
  counter_rate rate{};
  double per_minute = 0;
  for (int i = 0; i < 10 * 50; ++i) per_minute = counter_rate_step(&rate, 10, 0.02);
  EXPECT_NEAR(per_minute, 60, 1);
  for (int i = 0; i < 10 * 50; ++i) per_minute = counter_rate_step(&rate, 3, 0.02);
  EXPECT_NEAR(per_minute, 30, 1);
}

using namespace std::chrono_literals;

TEST(Counter, WritesTheNumberOfPartsPerMinute) {
  takt::testing::Module module{{.period = 20ms}};
  auto& state = module.in<line::BeltState>("state");
  auto& throughput = module.out<line::Throughput>("throughput");
  ASSERT_TRUE(module.start());
  line::BeltState belt;
  for (int second = 0; second < 120; ++second) {
    belt.parts(belt.parts() + 2);
    state.write(belt);
    module.step(50);
  }
  EXPECT_EQ(throughput.count(), 6000U);
  EXPECT_EQ(throughput.value().parts(), 240U);
  EXPECT_NEAR(throughput.value().per_minute(), 120, 3);
}

TEST(Counter, WritesZeroBeforeTheFirstBeltState) {
  takt::testing::Module module{{.period = 20ms}};
  auto& throughput = module.out<line::Throughput>("throughput");
  ASSERT_TRUE(module.start());
  module.step(10);
  EXPECT_EQ(throughput.value().parts(), 0U);
  EXPECT_EQ(throughput.value().per_minute(), 0);
}

}  // namespace
