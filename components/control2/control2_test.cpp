#include "velocity_loop.hpp"

#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include <takt/testing.hpp>

namespace control2 {
namespace {

constexpr double kPeriod = 100e-6;

TEST(Motor, ReachesTheNoLoadSpeedThatItsConstantsPredict) {
  Motor motor;
  for (int i = 0; i < 50000; ++i) motor.step(12, kPeriod);
  const double no_load =
      12 * motor.constant / (motor.constant * motor.constant + motor.resistance * motor.friction);
  EXPECT_NEAR(motor.speed, no_load, 0.01);
}

TEST(Pid, HasNoSteadyStateErrorAfterAStep) {
  Motor motor;
  Pid pid;
  motor.load = 0.1;
  for (int i = 0; i < 20000; ++i) motor.step(pid.step(100, motor.speed, kPeriod), kPeriod);
  EXPECT_NEAR(motor.speed, 100, 0.01);
}

TEST(Pid, NeverExceedsItsOutputLimit) {
  Pid pid{.limit = 24};
  EXPECT_EQ(pid.step(10000, 0, kPeriod), 24);
  EXPECT_EQ(pid.step(-10000, 0, kPeriod), -24);
}

TEST(Pid, DoesNotWindUpWhileItsOutputIsLimited) {
  Motor motor;
  Pid pid;
  // 24 V is not enough for 600 rad/s, so the output stays at its limit for one second.
  for (int i = 0; i < 10000; ++i) motor.step(pid.step(600, motor.speed, kPeriod), kPeriod);
  EXPECT_LT(motor.speed, 500);
  EXPECT_LT(pid.integral, 2 * pid.limit);
  // The output leaves the limit and the speed settles at once. With windup, the motor would stay at full
  // speed for seconds.
  for (int i = 0; i < 5000; ++i) motor.step(pid.step(200, motor.speed, kPeriod), kPeriod);
  EXPECT_NEAR(motor.speed, 200, 1);
}

TEST(Pid, WindsUpIfAntiWindupIsPracticallyOff) {
  Motor motor;
  Pid pid{.tracking = 1e9};
  for (int i = 0; i < 10000; ++i) motor.step(pid.step(600, motor.speed, kPeriod), kPeriod);
  for (int i = 0; i < 5000; ++i) motor.step(pid.step(200, motor.speed, kPeriod), kPeriod);
  EXPECT_GT(motor.speed, 250);
}

TEST(Pid, HasNoDerivativeKickOnASetPointStep) {
  Pid pid{.gain = 0, .integral_gain = 0, .derivative_gain = 0.001};
  EXPECT_EQ(pid.step(0, 0, kPeriod), 0);
  EXPECT_EQ(pid.step(100, 0, kPeriod), 0);
  EXPECT_LT(pid.step(100, 1, kPeriod), 0);
}

TEST(ErrorMeter, KeepsTheLargestError) {
  ErrorMeter meter;
  meter.step(1, kPeriod);
  meter.step(-3, kPeriod);
  meter.step(2, kPeriod);
  EXPECT_EQ(meter.largest, 3);
}

TEST(ErrorMeter, MeasuresTheMeanSquareOfASteadyError) {
  ErrorMeter meter;
  for (int i = 0; i < 100000; ++i) meter.step(i % 2 == 0 ? 2 : -2, kPeriod);
  EXPECT_NEAR(std::sqrt(meter.mean_square), 2, 0.001);
}

using namespace std::chrono_literals;

/// Returns the root mean square of the speed error over two seconds.
double error_of(const char* gain, const char* integral) {
  takt::testing::Module module{{.period = 100us}};
  EXPECT_TRUE(module.set("gain", gain));
  EXPECT_TRUE(module.set("integral", integral));
  EXPECT_TRUE(module.start());
  EXPECT_EQ(module.step(20'000), 20'000U);
  testing::internal::CaptureStderr();
  EXPECT_TRUE(module.destruct());
  double error = -1;
  EXPECT_EQ(
      std::sscanf(testing::internal::GetCapturedStderr().c_str(), "control2: speed error %lf rad/s", &error),
      1);
  return error;
}

TEST(Control2, FollowsItsSetPointBetterWithHigherGains) {
  const double loose = error_of("0", "0");
  const double tight = error_of("0.2", "10");
  EXPECT_GT(loose, 50);
  EXPECT_GT(tight, 0);
  EXPECT_LT(tight, loose / 10);
}

TEST(Control2, RunsAgainAfterAnError) {
  takt::testing::Module module{{.period = 100us}};
  ASSERT_TRUE(module.start());
  module.step(1000);
  ASSERT_TRUE(module.error(takt::ErrorType::budget));
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.step(1000), 1000U);
}

TEST(Control2, RejectsGainsOutOfRange) {
  takt::testing::Module module;
  EXPECT_FALSE(module.set("gain", "-1"));
  EXPECT_FALSE(module.set("voltage", "0"));
  EXPECT_TRUE(module.set("gain", "10"));
}

}  // namespace
}  // namespace control2
