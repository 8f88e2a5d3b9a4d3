#include "slew_limiter.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace rate_limiter {
namespace {

using common::flag;
using common::number;
using std::chrono::milliseconds;

constexpr double kPeriod = 1e-2;

TEST(SlewLimiter, HasSeparateLimitsForRisingAndFalling) {
  SlewLimiter limiter;
  const Limits limits{.up = 2, .down = 5};
  for (int i = 1; i <= 50; ++i) EXPECT_NEAR(limiter.step(1, limits, kPeriod), i * 0.02, 1e-12);
  EXPECT_EQ(limiter.step(1, limits, kPeriod), 1);
  for (int i = 1; i <= 20; ++i) EXPECT_NEAR(limiter.step(0, limits, kPeriod), 1 - i * 0.05, 1e-12);
  EXPECT_EQ(limiter.step(0, limits, kPeriod), 0);
}

TEST(SlewLimiter, PassesASlowInputUnchanged) {
  SlewLimiter limiter;
  std::mt19937 random(8);
  std::uniform_real_distribution<double> step(-0.0099, 0.0099);
  double wanted = 0;
  for (int i = 0; i < 10000; ++i) {
    wanted += step(random);
    ASSERT_EQ(limiter.step(wanted, {.up = 1, .down = 1}, kPeriod), wanted);
  }
}

TEST(SlewLimiter, NeverExceedsItsLimits) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> target(-3, 3);
  std::uniform_real_distribution<double> limit(0.1, 4);
  for (int n = 0; n < 200; ++n) {
    const Limits limits{
        .up = limit(random), .down = limit(random), .jerk = n % 2 == 0 ? 0 : limit(random) * 5};
    SlewLimiter limiter;
    double wanted = 0;
    double value = 0;
    double rate = 0;
    for (int i = 0; i < 500; ++i) {
      if (i % 60 == 0) wanted = target(random);
      limiter.step(wanted, limits, kPeriod);
      const double now = (limiter.value() - value) / kPeriod;
      ASSERT_LE(now, limits.up + 1e-9);
      ASSERT_GE(now, -limits.down - 1e-9);
      if (limits.jerk > 0) {
        ASSERT_LE(std::abs(now - rate), limits.jerk * kPeriod + 1e-9) << n << " " << i;
      }
      value = limiter.value();
      rate = now;
    }
  }
}

TEST(SlewLimiter, ReachesAConstantInputWithoutOvershoot) {
  std::mt19937 random(10);
  std::uniform_real_distribution<double> target(-5, 5);
  std::uniform_real_distribution<double> limit(0.1, 4);
  for (int n = 0; n < 2000; ++n) {
    SlewLimiter limiter;
    const double from = target(random);
    const double wanted = target(random);
    const Limits limits{.up = limit(random), .down = limit(random), .jerk = limit(random) * 10};
    limiter.jump(from);
    const double way = std::abs(wanted - from);
    const double rate = wanted > from ? limits.up : limits.down;
    int steps = 0;
    while (limiter.value() != wanted && steps < 100000) {
      limiter.step(wanted, limits, kPeriod);
      ++steps;
      const bool beyond = wanted > from ? limiter.value() > wanted + 1e-12 : limiter.value() < wanted - 1e-12;
      ASSERT_FALSE(beyond) << from << " " << wanted << " " << limiter.value();
    }
    // The shortest possible time in continuous theory: the rate ramps up and down equally, with a phase at
    // its limit in between if it reaches the limit.
    const double full = rate * rate / limits.jerk;
    const double least = way < full ? 2 * std::sqrt(way / limits.jerk) : way / rate + rate / limits.jerk;
    ASSERT_LE(steps * kPeriod, least + 3 * kPeriod) << from << " " << wanted;
    ASSERT_GE(steps * kPeriod, least - 3 * kPeriod);
    for (int i = 0; i < 5; ++i) ASSERT_EQ(limiter.step(wanted, limits, kPeriod), wanted);
  }
}

TEST(SlewLimiter, KeepsTheJerkLimitWhenItsRateLimitFalls) {
  SlewLimiter limiter;
  Limits limits{.up = 2, .down = 2, .jerk = 10};
  for (int i = 0; i < 100; ++i) limiter.step(1000, limits, kPeriod);
  EXPECT_DOUBLE_EQ(limiter.rate(), 2);
  limits.up = 1;
  double last = limiter.rate();
  for (int i = 0; i < 20; ++i) {
    limiter.step(1000, limits, kPeriod);
    EXPECT_LE(last - limiter.rate(), 0.1 + 1e-12);
    last = limiter.rate();
  }
  EXPECT_DOUBLE_EQ(last, 1);
}

TEST(RateLimiter, RampsFromItsFirstInputToTheNext) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  auto& limiting = module.out<basic::Flag>("limiting");
  ASSERT_TRUE(module.set("rate_up", "5"));
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_FALSE(out.has_value());
  in.write(number(7));
  module.step();
  EXPECT_EQ(out.value().value(), 7);
  EXPECT_FALSE(limiting.value().value());
  in.write(number(8));
  module.step(10);
  EXPECT_NEAR(out.value().value(), 7.5, 1e-9);
  EXPECT_TRUE(limiting.value().value());
  module.step(10);
  EXPECT_EQ(out.value().value(), 8);
  EXPECT_FALSE(limiting.value().value());
}

TEST(RateLimiter, PassesTheInputUnchangedWhileDisabled) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Number>("in");
  auto& enable = module.in<basic::Flag>("enable");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(0));
  module.step();
  enable.write(flag(false));
  in.write(number(100));
  module.step();
  EXPECT_EQ(out.value().value(), 100);
  enable.write(flag(true));
  in.write(number(0));
  module.step();
  EXPECT_NEAR(out.value().value(), 100 - 0.01, 1e-12);
}

TEST(RateLimiter, CatchesUpOnMissedReleases) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(0));
  module.step();
  in.write(number(1));
  module.miss(9);
  module.step();
  EXPECT_NEAR(out.value().value(), 0.1, 1e-12);
}

TEST(RateLimiter, ContinuesFromItsLastOutputAfterAnError) {
  takt::testing::Module module{{.period = milliseconds{10}}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(5));
  module.step();
  in.write(number(-std::numeric_limits<double>::infinity()));
  module.step();
  EXPECT_EQ(module.last_error().type, takt::ErrorType::failure);
  in.write(number(0));
  ASSERT_TRUE(module.recover());
  module.step();
  EXPECT_NEAR(out.value().value(), 5 - 0.01, 1e-12);
}

}  // namespace
}  // namespace rate_limiter
