#include "pid_loop.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace pid {
namespace {

using common::flag;
using common::number;
using std::chrono::milliseconds;

constexpr Tuning kWide{.low = -1e9, .high = 1e9};
constexpr double kPeriod = 1e-2;

Tuning pi() {
  Tuning tuning = kWide;
  tuning.gain = 2;
  tuning.integral_time = 0.5;
  return tuning;
}

TEST(PidLoop, IsProportionalWithoutIntegralAndDerivativeTimes) {
  PidLoop loop;
  Tuning tuning = kWide;
  tuning.gain = 3;
  tuning.setpoint_weight = 0.5;
  loop.tune(tuning);
  EXPECT_DOUBLE_EQ(loop.automatic(10, 4, kPeriod), 3 * (0.5 * 10 - 4));
}

TEST(PidLoop, IntegratesAConstantErrorExactlyForAnyPeriod) {
  for (const double dt : {1e-5, 1e-3, 0.3}) {
    PidLoop loop;
    loop.tune(pi());
    loop.automatic(0, 0, dt);
    // The first output is the proportional part, 2, plus the integral over half a period.
    const double first = loop.automatic(1, 0, dt);
    double last = first;
    for (int i = 0; i < 1000; ++i) last = loop.automatic(1, 0, dt);
    EXPECT_NEAR(first, 2 + 2 / 0.5 * dt / 2, 1e-12);
    EXPECT_NEAR(last - first, 2 / 0.5 * 1000 * dt, 1e-9 * last);
  }
}

TEST(PidLoop, IntegratesOverTheTimeOfMissedReleases) {
  PidLoop one;
  PidLoop other;
  one.tune(pi());
  other.tune(pi());
  for (PidLoop* loop : {&one, &other}) {
    loop->automatic(0, 0, kPeriod);
    loop->automatic(1, 0, kPeriod);
  }
  for (int i = 0; i < 5; ++i) one.automatic(1, 0, kPeriod);
  other.automatic(1, 0, 5 * kPeriod);
  EXPECT_NEAR(one.output(), other.output(), 1e-12);
}

TEST(PidLoop, DifferentiatesTheFilteredMeasurement) {
  Tuning tuning = kWide;
  tuning.gain = 2;
  tuning.derivative_time = 0.5;
  tuning.derivative_filter = 5;  // a filter time of 0.1 s
  PidLoop loop;
  loop.tune(tuning);
  loop.automatic(0, 0, kPeriod);
  double measured = 0;
  for (int i = 1; i <= 500; ++i) {
    measured = 3 * i * kPeriod;
    const double d = loop.automatic(0, measured, kPeriod) + 2 * measured;
    // The expected value is -K Td slope (1 - r^n) with r = Tf / (Tf + h): a backward difference with a
    // first-order filter.
    ASSERT_NEAR(d, -2 * 0.5 * 3 * (1 - std::pow(0.1 / 0.11, i)), 1e-9) << i;
  }
}

TEST(PidLoop, DoesNotDifferentiateTheSetPoint) {
  Tuning tuning = kWide;
  tuning.derivative_time = 1;
  PidLoop loop;
  loop.tune(tuning);
  loop.automatic(0, 0, kPeriod);
  EXPECT_DOUBLE_EQ(loop.automatic(1, 0, kPeriod), 1);  // the output is only the proportional part
}

TEST(PidLoop, DoesNotRingWithADerivativeFilterShorterThanThePeriod) {
  Tuning tuning = kWide;
  tuning.derivative_time = 1e-4;
  tuning.derivative_filter = 100;
  PidLoop loop;
  loop.tune(tuning);
  loop.automatic(0, 0, kPeriod);
  loop.automatic(0, 1, kPeriod);
  double last = 1e9;
  for (int i = 0; i < 20; ++i) {
    const double d = std::abs(loop.automatic(0, 1, kPeriod) + 1);
    EXPECT_LE(d, last);
    last = d;
  }
  EXPECT_LT(last, 1e-12);
}

/// Sets a set point for which the output must stay at its limit, and then a set point for which it need not.
/// Returns for how many steps after this change the output stays at its limit.
int steps_at_the_limit(double tracking_time) {
  Tuning tuning = pi();
  tuning.low = 0;
  tuning.high = 1;
  tuning.tracking_time = tracking_time;
  PidLoop loop;
  loop.tune(tuning);
  loop.automatic(0, 0, kPeriod);
  for (int i = 0; i < 2000; ++i) EXPECT_LE(loop.automatic(10, 0, kPeriod), 1);
  int steps = 0;
  while (loop.automatic(-0.1, 0, kPeriod) >= 1 && steps < 1000000) ++steps;
  return steps;
}

TEST(PidLoop, LeavesItsLimitSoonerWithAShorterTrackingTime) {
  EXPECT_LE(steps_at_the_limit(1e-6), 1);  // the loop is stable even if this time is far below the period
  // While the output rests at its limit, the integral changes by K error / Ti - e / Tt = 0, so the excess e
  // is K error Tt / Ti = 40 Tt. The step of the set point then removes K 10.1 = 20.2 at once. With Tt = 0.5
  // s, this is all of e.
  EXPECT_LE(steps_at_the_limit(0.5), 1);
  // With Tt = 2 s, an excess e of 59.8 remains, which decays by de/dt = -e / Tt - 0.4 within
  // Tt ln((59.8 + 0.8) / 0.8) = 8.65 s.
  const int slow = steps_at_the_limit(2);
  EXPECT_NEAR(slow, 865, 3);
  EXPECT_GT(steps_at_the_limit(1e6), 100 * slow);  // practically without tracking, the integral winds up
}

TEST(PidLoop, LeavesItsLimitExactlyWhenTheoryPredicts) {
  Tuning tuning = pi();
  tuning.low = 0;
  tuning.high = 1;
  tuning.tracking_time = 0.25;
  PidLoop loop;
  loop.tune(tuning);
  loop.automatic(0, 0, kPeriod);
  for (int i = 0; i < 2000; ++i) loop.automatic(3, 0, kPeriod);
  // In each step, the integral first gains a = K e h / Ti and then loses the fraction s = 1 - exp(-h / Tt) of
  // the excess.
  const double gain = 2 * 3 * kPeriod / 0.5;
  const double share = 1 - std::exp(-kPeriod / 0.25);
  const double excess = gain / share;
  // The error that exactly removes this excess puts the output exactly at its limit.
  const double error = 3 - (excess * (1 - share)) / 2;
  // In the step that changes the error, the integral gains the mean of the old and the new error.
  const double output = loop.automatic(error, 0, kPeriod);
  EXPECT_NEAR(output, std::min(1.0, 1 + (3 + error) / 2 * 2 * kPeriod / 0.5), 1e-9);
  EXPECT_LT(loop.automatic(error - 1, 0, kPeriod), 1);
}

TEST(PidLoop, SwitchesFromManualWithoutAJump) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> value(-5, 5);
  for (int n = 0; n < 1000; ++n) {
    Tuning tuning = pi();
    tuning.derivative_time = 0.1;
    tuning.setpoint_weight = 0.3;
    PidLoop loop;
    loop.tune(tuning);
    const double setpoint = value(random);
    const double measured = value(random);
    const double by_hand = value(random);
    for (int i = 0; i < 1000; ++i) loop.manual(setpoint, measured, by_hand, kPeriod);
    // The first automatic output differs from the manual output only by one step of the integral.
    EXPECT_NEAR(loop.automatic(setpoint, measured, kPeriod),
                by_hand + 2 * (setpoint - measured) * kPeriod / 0.5, 1e-9);
  }
}

TEST(PidLoop, ChangesItsTuningWithoutAJump) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> value(0.1, 5);
  PidLoop loop;
  Tuning tuning = pi();
  loop.tune(tuning);
  double output = loop.automatic(1, 0.5, kPeriod);
  for (int n = 0; n < 5000; ++n) {
    tuning.gain = value(random);
    tuning.integral_time = value(random);
    tuning.derivative_time = n % 3 == 0 ? 0 : value(random);
    tuning.derivative_filter = 2 + value(random);
    tuning.setpoint_weight = value(random) / 5;
    const double measured = 0.5 + 0.1 * std::sin(n * 1e-3);
    loop.tune(tuning);
    const double now = loop.automatic(1, measured, kPeriod);
    // The largest possible change: one step of the integral, plus the P and D parts for a measurement that
    // moves by 1e-4.
    const double most = tuning.gain * kPeriod / tuning.integral_time +
                        tuning.gain * (1 + tuning.derivative_filter) * 2e-4 +
                        tuning.gain * tuning.derivative_filter * 0.1;
    ASSERT_LT(std::abs(now - output), most) << n;
    output = now;
  }
}

TEST(PidLoop, KeepsItsOutputWhenOnlyItsTuningChanges) {
  PidLoop loop;
  Tuning tuning = pi();
  tuning.derivative_time = 0.2;
  loop.tune(tuning);
  for (int i = 0; i < 50; ++i) loop.automatic(1, 0.02 * i, kPeriod);
  const double before = loop.automatic(1, 1, kPeriod);
  tuning.gain = 9;
  tuning.setpoint_weight = 0;
  tuning.derivative_time = 0;
  tuning.integral_time = 1e6;  // long, so that the integral does not move
  loop.tune(tuning);
  EXPECT_NEAR(loop.automatic(1, 1, 1e-9), before, 1e-9);
}

/// The process is y' = (u - y) / T with T = 1 s, and each step is exact. With Ti = T, the closed loop is y' =
/// K (r - y) / T.
TEST(PidLoop, FollowsTheTheoreticalStepResponse) {
  constexpr double kGain = 4;
  constexpr double kStep = 1e-4;
  Tuning tuning = kWide;
  tuning.gain = kGain;
  tuning.integral_time = 1;
  PidLoop loop;
  loop.tune(tuning);
  double y = 0;
  loop.automatic(0, 0, kStep);
  for (int i = 0; i < 20000; ++i) {
    ASSERT_NEAR(y, 1 - std::exp(-kGain * i * kStep), 1e-3) << i;
    const double u = loop.automatic(1, y, kStep);
    y += (1 - std::exp(-kStep)) * (u - y);
  }
}

TEST(PidLoop, StaysWithinItsLimitsForRandomInputs) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> value(-100, 100);
  PidLoop loop;
  for (int n = 0; n < 20000; ++n) {
    Tuning tuning{.gain = value(random) / 10,
                  .integral_time = n % 5 == 0 ? 0 : std::abs(value(random)) + kPeriod,
                  .derivative_time = std::abs(value(random)) / 50,
                  .low = -3,
                  .high = 2};
    if (n % 100 == 0) loop.tune(tuning);
    const double output = n % 7 == 0 ? loop.manual(value(random), value(random), value(random), kPeriod)
                                     : loop.automatic(value(random), value(random), kPeriod);
    ASSERT_TRUE(output >= -3 && output <= 2) << n << " " << output;
  }
}

class PidModule : public ::testing::Test {
 protected:
  takt::testing::Module module{{.period = milliseconds{10}}};
  takt::testing::In<basic::Number>& measured = module.in<basic::Number>("measured");
  takt::testing::Out<basic::Number>& output = module.out<basic::Number>("output");
  void SetUp() override {
    ASSERT_TRUE(module.set("gain", "2"));
    ASSERT_TRUE(module.set("integral_time", "0.5"));
    ASSERT_TRUE(module.set("output_min", "-100"));
    ASSERT_TRUE(module.set("output_max", "100"));
  }
};

TEST_F(PidModule, WritesNothingBeforeItHasAMeasurement) {
  ASSERT_TRUE(module.start());
  module.step(10);
  EXPECT_FALSE(output.has_value());
  measured.write(number(1));
  module.step();
  EXPECT_TRUE(output.has_value());
}

TEST_F(PidModule, StartsWithoutAJumpAndThenIntegratesTheError) {
  ASSERT_TRUE(module.set("setpoint", "3"));
  ASSERT_TRUE(module.start());
  measured.write(number(1));
  module.step();
  const double first = output.value().value();
  EXPECT_NEAR(first, 2 * 2 * 0.01 / 0.5, 1e-12);
  module.step(50);
  EXPECT_NEAR(output.value().value() - first, 2 * 2 * 0.5 / 0.5, 1e-9);
}

TEST_F(PidModule, UsesTheSetPointFromItsPortIfConnected) {
  auto& setpoint = module.in<basic::Number>("setpoint");
  ASSERT_TRUE(module.set("setpoint", "99"));
  ASSERT_TRUE(module.start());
  measured.write(number(0));
  module.step();
  EXPECT_FALSE(output.has_value());  // no output: the port is connected but has no sample yet
  setpoint.write(number(0));
  module.step(100);
  EXPECT_NEAR(output.value().value(), 0, 1e-12);
}

TEST_F(PidModule, SwitchesToManualAndBackWithoutAJump) {
  auto& manual = module.in<basic::Flag>("manual");
  auto& by_hand = module.in<basic::Number>("manual_value");
  ASSERT_TRUE(module.set("setpoint", "1"));
  ASSERT_TRUE(module.start());
  measured.write(number(0));
  module.step(100);
  const double before = output.value().value();
  manual.write(flag(true));
  module.step(10);
  EXPECT_EQ(output.value().value(), before);  // unchanged: no manual value has arrived yet
  by_hand.write(number(42));
  module.step(10);
  EXPECT_EQ(output.value().value(), 42);
  by_hand.write(number(1000));
  module.step();
  EXPECT_EQ(output.value().value(), 100);  // the upper limit of the output
  by_hand.write(number(42));
  module.step();
  manual.write(flag(false));
  module.step();
  EXPECT_NEAR(output.value().value(), 42 + 2 * 0.01 / 0.5, 1e-9);
}

TEST_F(PidModule, ChangesItsGainWithoutAJumpWhileItRuns) {
  ASSERT_TRUE(module.set("setpoint", "1"));
  ASSERT_TRUE(module.start());
  measured.write(number(0.5));
  module.step(20);
  const double before = output.value().value();
  ASSERT_TRUE(module.set("gain", "20"));
  module.step();
  EXPECT_NEAR(output.value().value(), before + 20 * 0.5 * 0.01 / 0.5, 1e-9);
}

TEST_F(PidModule, ContinuesFromItsLastOutputAfterACrash) {
  ASSERT_TRUE(module.set("setpoint", "1"));
  ASSERT_TRUE(module.start());
  measured.write(number(0));
  module.step(100);
  const double before = output.value().value();
  EXPECT_GT(before, 1);
  ASSERT_TRUE(module.crash());
  ASSERT_TRUE(module.recover());
  module.step();
  EXPECT_NEAR(output.value().value(), before, 2 * 0.01 / 0.5 + 1e-9);
}

TEST_F(PidModule, IntegratesOverTheTimeOfMissedReleases) {
  ASSERT_TRUE(module.set("setpoint", "1"));
  ASSERT_TRUE(module.start());
  measured.write(number(0));
  module.step();
  const double before = output.value().value();
  module.miss(9);
  module.step();
  EXPECT_NEAR(output.value().value() - before, 2 * 0.1 / 0.5, 1e-9);
}

TEST_F(PidModule, DoesNotStartWithInconsistentProperties) {
  ASSERT_TRUE(module.set("integral_time", "0.005"));
  const auto start = module.start();
  ASSERT_FALSE(start.ok());
  EXPECT_EQ(
      start.text(),
      "integral_time is shorter than the period; set output_min < output_max, and integral_time to 0 (none) "
      "or to at least the period, 10 ms");
}

TEST_F(PidModule, KeepsItsTuningWhileNewValuesAreInconsistent) {
  ASSERT_TRUE(module.set("setpoint", "1000000"));
  ASSERT_TRUE(module.start());
  measured.write(number(0));
  module.step(100);
  ASSERT_TRUE(module.set("output_max", "-200"));  // below output_min, so inconsistent
  module.step();
  EXPECT_EQ(output.value().value(), 100);
  ASSERT_TRUE(module.set("output_min", "-300"));
  module.step();
  EXPECT_EQ(output.value().value(), -200);
}

TEST_F(PidModule, ContinuesFromItsLastOutputAfterANonFiniteInput) {
  ASSERT_TRUE(module.set("setpoint", "1"));
  ASSERT_TRUE(module.start());
  measured.write(number(0));
  module.step(100);
  const double before = output.value().value();
  measured.write(number(std::nan("")));
  module.step();
  EXPECT_EQ(module.last_error().text, "an input is not a finite number");
  EXPECT_EQ(output.value().value(), before);
  measured.write(number(0.2));
  ASSERT_TRUE(module.recover());
  module.step();
  EXPECT_NEAR(output.value().value(), before + 2 * 0.8 * 0.01 / 0.5, 1e-9);
}

}  // namespace
}  // namespace pid
