#include "limit_alarm.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace limit_monitor {
namespace {

using common::flag;
using common::number;
using std::chrono::milliseconds;

TEST(LimitAlarm, EndsOnlyWhenTheValueIsInsideTheLimitByTheHysteresis) {
  LimitAlarm alarm;
  const LimitAlarm::Settings settings{.hysteresis = 2};
  EXPECT_FALSE(alarm.step(0, settings, false, 1));  // a value at the limit is not beyond it
  EXPECT_TRUE(alarm.step(0.1, settings, false, 1));
  EXPECT_TRUE(alarm.step(-1.9, settings, false, 1));
  EXPECT_FALSE(alarm.step(-2, settings, false, 1));
  EXPECT_FALSE(alarm.step(-1.9, settings, false, 1));
}

TEST(LimitAlarm, StartsOnlyAfterAnUninterruptedDelay) {
  LimitAlarm alarm;
  const LimitAlarm::Settings settings{.delay_ns = 30};
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(alarm.step(1, settings, false, 10)) << i;
  EXPECT_FALSE(alarm.step(-1, settings, false, 10));
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(alarm.step(1, settings, false, 10)) << i;
  EXPECT_TRUE(alarm.step(1, settings, false, 10));
}

TEST(LimitAlarm, StaysLatchedUntilAcknowledgedInsideTheLimit) {
  LimitAlarm alarm;
  const LimitAlarm::Settings settings{.latching = true};
  EXPECT_TRUE(alarm.step(1, settings, false, 10));
  EXPECT_TRUE(alarm.step(1, settings, true, 10));
  EXPECT_TRUE(alarm.step(-1, settings, false, 10));
  EXPECT_FALSE(alarm.step(-1, settings, true, 10));
}

/// Compares the alarm with a slow implementation that checks every earlier value in each step.
TEST(LimitAlarm, MatchesASimpleReferenceForRandomValues) {
  std::mt19937 random(11);
  for (int n = 0; n < 100; ++n) {
    const LimitAlarm::Settings settings{
        .delay_ns = n % 7 * 10, .hysteresis = n % 4 * 0.3, .latching = n % 3 == 0};
    std::uniform_real_distribution<double> step(-0.5, 0.5);
    LimitAlarm alarm;
    std::vector<double> values;
    double value = 0;
    bool expected = false;
    for (int i = 0; i < 500; ++i) {
      value = std::clamp(value + step(random), -2.0, 2.0);
      values.push_back(value);
      const bool acknowledge = random() % 20 == 0;
      std::int64_t beyond = 0;
      for (auto last = values.rbegin(); last != values.rend() && *last > 0; ++last) ++beyond;
      if (beyond > 0 && (beyond - 1) * 10 >= settings.delay_ns)
        expected = true;
      else if (value <= -settings.hysteresis && (!settings.latching || acknowledge))
        expected = false;
      ASSERT_EQ(alarm.step(value, settings, acknowledge, 10), expected) << n << " " << i;
    }
  }
}

class LimitMonitor : public ::testing::Test {
 protected:
  takt::testing::Module module{{.period = milliseconds{10}}};
  takt::testing::In<basic::Number>& value = module.in<basic::Number>("value");
  takt::testing::In<basic::Flag>& reset = module.in<basic::Flag>("reset");
  takt::testing::Out<basic::Flag>& high = module.out<basic::Flag>("high_alarm");
  takt::testing::Out<basic::Flag>& low = module.out<basic::Flag>("low_alarm");
  takt::testing::Out<basic::Flag>& ok = module.out<basic::Flag>("ok");
  void SetUp() override {
    ASSERT_TRUE(module.set("high", "10"));
    ASSERT_TRUE(module.set("low", "-5"));
    ASSERT_TRUE(module.set("hysteresis", "1"));
  }
  void is(double x) {
    value.write(number(x));
    module.step();
  }
};

TEST_F(LimitMonitor, IsNotOkBeforeItsFirstValue) {
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_FALSE(ok.value().value());
  is(0);
  EXPECT_TRUE(ok.value().value());
}

TEST_F(LimitMonitor, ReportsWhichLimitIsExceeded) {
  ASSERT_TRUE(module.start());
  is(10.5);
  EXPECT_TRUE(high.value().value());
  EXPECT_FALSE(low.value().value());
  EXPECT_FALSE(ok.value().value());
  is(-6);
  EXPECT_FALSE(high.value().value());
  EXPECT_TRUE(low.value().value());
  is(-4);
  EXPECT_TRUE(ok.value().value());
}

TEST_F(LimitMonitor, CountsMissedReleasesInItsDelay) {
  ASSERT_TRUE(module.set("delay", "0.05"));
  ASSERT_TRUE(module.start());
  is(20);
  module.miss(3);
  module.step();  // the value has been beyond the limit for 40 ms
  EXPECT_FALSE(high.value().value());
  module.step();
  EXPECT_TRUE(high.value().value());
}

TEST_F(LimitMonitor, IsNotOkWhileItsValueIsNotFinite) {
  ASSERT_TRUE(module.start());
  is(0);
  is(std::nan(""));
  EXPECT_FALSE(ok.value().value());
  EXPECT_FALSE(high.value().value());
  is(std::numeric_limits<double>::infinity());
  EXPECT_FALSE(ok.value().value());
  is(0);
  EXPECT_TRUE(ok.value().value());
}

TEST_F(LimitMonitor, NeedsAResetAfterANonFiniteValueIfLatching) {
  ASSERT_TRUE(module.set("latching", "true"));
  ASSERT_TRUE(module.start());
  is(std::nan(""));
  is(0);
  EXPECT_FALSE(ok.value().value());
  reset.write(flag(true));
  module.step();
  EXPECT_TRUE(ok.value().value());
}

TEST_F(LimitMonitor, DoesNotStartIfLowIsAboveHigh) {
  ASSERT_TRUE(module.set("low", "11"));
  const auto start = module.start();
  ASSERT_FALSE(start.ok());
  EXPECT_NE(start.text().find("low < high"), std::string::npos) << start.text();
}

TEST_F(LimitMonitor, KeepsItsPreviousLimitsWhileTheNewLimitsAreInconsistent) {
  ASSERT_TRUE(module.start());
  is(0);
  ASSERT_TRUE(module.set("high", "-10"));
  module.step();
  EXPECT_TRUE(ok.value().value());
  ASSERT_TRUE(module.set("low", "-20"));
  module.step();
  EXPECT_TRUE(high.value().value());
}

TEST_F(LimitMonitor, IsNotOkAfterAnError) {
  ASSERT_TRUE(module.start());
  is(0);
  ASSERT_TRUE(module.error(takt::ErrorType::budget));
  EXPECT_FALSE(ok.value().value());
}

}  // namespace
}  // namespace limit_monitor
