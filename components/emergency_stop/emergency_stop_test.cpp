#include "two_channel_stop.hpp"

#include <gtest/gtest.h>

#include <random>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace emergency_stop {
namespace {

using common::flag;
using std::chrono::milliseconds;

constexpr TwoChannelStop::Inputs kClosed{
    .a = true, .b = true, .fresh = true, .reset = false, .reset_fresh = true};
constexpr TwoChannelStop::Inputs kOpen{
    .a = false, .b = false, .fresh = true, .reset = false, .reset_fresh = true};

TwoChannelStop::Inputs with_reset(TwoChannelStop::Inputs in) {
  in.reset = true;
  return in;
}
TwoChannelStop::Inputs one_open(bool a) {
  TwoChannelStop::Inputs in = kClosed;
  (a ? in.a : in.b) = false;
  return in;
}

class TwoChannelLogic : public ::testing::Test {
 protected:
  TwoChannelStop stop;
  State step(const TwoChannelStop::Inputs& in) { return stop.step(in, 10, 100); }
  void permit() {
    step(kOpen);
    step(kClosed);
    ASSERT_EQ(step(with_reset(kClosed)), State::permitted);
  }
};

TEST_F(TwoChannelLogic, PermitsNothingAtTheStart) {
  EXPECT_EQ(step(kClosed), State::wait_reset);
  EXPECT_EQ(step(kClosed), State::wait_reset);
}

TEST_F(TwoChannelLogic, PermitsOnARisingEdgeOfTheReset) {
  step(kClosed);
  EXPECT_EQ(step(with_reset(kClosed)), State::permitted);
  EXPECT_EQ(step(kClosed), State::permitted);
}

TEST_F(TwoChannelLogic, NeedsNoResetAfterTheStartIfStartResetIsTrue) {
  TwoChannelStop::Inputs closed = kClosed;
  closed.start_reset = true;
  TwoChannelStop::Inputs open = kOpen;
  open.start_reset = true;
  EXPECT_EQ(step(open), State::stopped);
  EXPECT_EQ(step(closed), State::permitted);
  step(open);
  EXPECT_EQ(step(closed), State::wait_reset) << "start_reset must permit only the first time";
  stop.trip();
  EXPECT_EQ(step(closed), State::wait_reset) << "start_reset must not permit after an error";
}

TEST_F(TwoChannelLogic, IgnoresAResetButtonThatIsHeld) {
  for (int i = 0; i < 5; ++i) EXPECT_EQ(step(with_reset(kClosed)), State::wait_reset);
  permit();
  step(with_reset(kOpen));
  for (int i = 0; i < 5; ++i) EXPECT_EQ(step(with_reset(kClosed)), State::wait_reset);
}

TEST_F(TwoChannelLogic, IgnoresAResetEdgeInTheStepInWhichTheChannelsClose) {
  step(kOpen);
  EXPECT_EQ(step(with_reset(kClosed)), State::wait_reset);
}

TEST_F(TwoChannelLogic, StopsAtOnceIfEitherChannelOpens) {
  for (const bool a : {true, false}) {
    permit();
    EXPECT_EQ(step(one_open(a)), State::stopped);
    EXPECT_EQ(step(kOpen), State::stopped);
    EXPECT_EQ(step(kClosed), State::wait_reset);
  }
}

TEST_F(TwoChannelLogic, ReportsADiscrepancyIfTheOtherChannelDoesNotOpen) {
  permit();
  for (int i = 0; i < 10; ++i) EXPECT_EQ(step(one_open(true)), State::stopped) << i;
  EXPECT_EQ(step(one_open(true)), State::discrepancy);
  // Until both channels have been open, neither time nor a reset ends the discrepancy.
  EXPECT_EQ(step(kClosed), State::discrepancy);
  EXPECT_EQ(step(with_reset(kClosed)), State::discrepancy);
  EXPECT_EQ(step(kOpen), State::stopped);
  EXPECT_EQ(step(kClosed), State::wait_reset);
  EXPECT_EQ(step(with_reset(kClosed)), State::permitted);
}

TEST_F(TwoChannelLogic, ReportsADiscrepancyEvenIfTheFirstChannelClosesAgain) {
  permit();
  step(one_open(false));
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(step(i % 2 == 0 ? kClosed : with_reset(kClosed)), State::stopped) << i;
  }
  EXPECT_EQ(step(kClosed), State::discrepancy);
}

TEST_F(TwoChannelLogic, ReportsADiscrepancyIfOnlyOneChannelCloses) {
  step(kOpen);
  for (int i = 0; i < 10; ++i) step(one_open(true));
  EXPECT_EQ(step(one_open(true)), State::discrepancy);
}

TEST_F(TwoChannelLogic, StopsIfTheChannelsHaveNoRecentSample) {
  permit();
  TwoChannelStop::Inputs silent = kClosed;
  silent.fresh = false;
  EXPECT_EQ(step(silent), State::no_signal);
  EXPECT_EQ(step(kClosed), State::wait_reset);
}

TEST_F(TwoChannelLogic, IgnoresAResetButtonThatItHasNotSeenReleased) {
  TwoChannelStop::Inputs unheard = kClosed;
  unheard.reset_fresh = false;
  step(unheard);
  EXPECT_EQ(step(with_reset(kClosed)), State::wait_reset);
}

TEST_F(TwoChannelLogic, FollowsItsRulesForRandomInputs) {
  std::mt19937 random(13);
  bool permitted = false;
  bool both_last = false;      // both channels were closed and fresh at the last step
  bool released_last = false;  // the logic saw the button released at the last step
  for (int i = 0; i < 200000; ++i) {
    const TwoChannelStop::Inputs in{.a = random() % 8 != 0,
                                    .b = random() % 8 != 0,
                                    .fresh = random() % 10 != 0,
                                    .reset = random() % 2 == 0,
                                    .reset_fresh = random() % 10 != 0};
    const bool now = step(in) == State::permitted;
    const bool both = in.a && in.b && in.fresh;
    if (now) {
      ASSERT_TRUE(both) << i;
      if (!permitted) {
        ASSERT_TRUE(both_last && released_last && in.reset && in.reset_fresh) << i;
      }
    } else if (permitted) {
      ASSERT_FALSE(both) << i;  // nothing but an open or stale channel may cause a stop
    }
    permitted = now;
    both_last = both;
    released_last = in.reset_fresh && !in.reset;
  }
}

class EmergencyStop : public ::testing::Test {
 protected:
  takt::testing::Module module{{.period = milliseconds{10}}};
  takt::testing::In<basic::Flag>& a = module.in<basic::Flag>("channel_a");
  takt::testing::In<basic::Flag>& b = module.in<basic::Flag>("channel_b");
  takt::testing::In<basic::Flag>& reset = module.in<basic::Flag>("reset");
  takt::testing::Out<basic::Flag>& permitted = module.out<basic::Flag>("run_permitted");
  takt::testing::Out<basic::Count>& state = module.out<basic::Count>("state");
  void cycle(bool channel_a, bool channel_b, bool button) {
    a.write(flag(channel_a));
    b.write(flag(channel_b));
    reset.write(flag(button));
    module.step();
  }
  void permit() {
    cycle(true, true, false);
    cycle(true, true, true);
    ASSERT_TRUE(permitted.value().value());
  }
};

TEST_F(EmergencyStop, WritesItsOutputsEveryCycle) {
  ASSERT_TRUE(module.start());
  module.step(100);
  EXPECT_EQ(permitted.count(), 100U);
  EXPECT_FALSE(permitted.value().value());
  EXPECT_EQ(state.value().value(), 4);
}

TEST_F(EmergencyStop, PermitsAgainAfterAStopAndAReset) {
  ASSERT_TRUE(module.start());
  permit();
  EXPECT_FALSE(module.in_safe_stop());
  cycle(false, false, false);
  EXPECT_FALSE(permitted.value().value());
  EXPECT_EQ(state.value().value(), 1);
  EXPECT_TRUE(module.in_safe_stop());
  permit();
  EXPECT_FALSE(module.in_safe_stop());
}

TEST_F(EmergencyStop, StopsIfAChannelTimesOut) {
  ASSERT_TRUE(module.start());
  permit();
  for (int i = 0; i < 10; ++i) {
    b.write(flag(true));
    module.step();
    EXPECT_TRUE(permitted.value().value()) << i;
  }
  b.write(flag(true));
  module.step();
  EXPECT_FALSE(permitted.value().value());
  EXPECT_EQ(state.value().value(), 4);
}

TEST_F(EmergencyStop, StopsIfItsInputsBecomeTooOldDuringMissedReleases) {
  ASSERT_TRUE(module.start());
  permit();
  module.miss(20);
  module.step();
  EXPECT_FALSE(permitted.value().value());
}

TEST_F(EmergencyStop, NeedsAResetAfterAnError) {
  ASSERT_TRUE(module.start());
  permit();
  ASSERT_TRUE(module.error(takt::ErrorType::budget));
  EXPECT_FALSE(permitted.value().value());
  ASSERT_TRUE(module.recover());
  cycle(true, true, true);
  EXPECT_FALSE(permitted.value().value());
  permit();
}

TEST_F(EmergencyStop, PermitsNothingIfOneChannelIsNotConnected) {
  takt::testing::Module half{{.period = milliseconds{10}}};
  auto& only = half.in<basic::Flag>("channel_a");
  auto& button = half.in<basic::Flag>("reset");
  auto& out = half.out<basic::Flag>("run_permitted");
  ASSERT_TRUE(half.start());
  for (int i = 0; i < 20; ++i) {
    only.write(flag(true));
    button.write(flag(i % 2 == 1));
    half.step();
    ASSERT_FALSE(out.value().value());
  }
}

TEST_F(EmergencyStop, RejectsATimeoutShorterThanItsPeriod) {
  ASSERT_TRUE(module.set("timeout", "0.005"));
  EXPECT_EQ(module.start().text(),
            "property 'timeout' cannot be '0.005'; it takes a number, 0.01 to 10 at a period of 10 ms, in s");
}

}  // namespace
}  // namespace emergency_stop
