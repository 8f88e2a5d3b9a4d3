#include <components/control2/velocity_loop.hpp>

#include <gtest/gtest.h>

namespace control2 {
namespace {

constexpr double kPeriod = 100e-6;

TEST(Motor, ReachesTheSpeedThatItsConstantsSay) {
  Motor motor;
  for (int i = 0; i < 50000; ++i) motor.step(12, kPeriod);
  const double no_load =
      12 * motor.constant / (motor.constant * motor.constant + motor.resistance * motor.friction);
  EXPECT_NEAR(motor.speed, no_load, 0.01);
}

TEST(Pid, BringsTheMotorToAStepWithoutLastingError) {
  Motor motor;
  Pid pid;
  motor.load = 0.1;
  for (int i = 0; i < 20000; ++i) motor.step(pid.step(100, motor.speed, kPeriod), kPeriod);
  EXPECT_NEAR(motor.speed, 100, 0.01);
}

TEST(Pid, NeverAsksForMoreThanItsLimit) {
  Pid pid{.limit = 24};
  EXPECT_EQ(pid.step(10000, 0, kPeriod), 24);
  EXPECT_EQ(pid.step(-10000, 0, kPeriod), -24);
}

TEST(Pid, DoesNotWindUpWhileItIsBounded) {
  Motor motor;
  Pid pid;
  // 600 rad/s is above what 24 V can give: one second at the bound.
  for (int i = 0; i < 10000; ++i) motor.step(pid.step(600, motor.speed, kPeriod), kPeriod);
  EXPECT_LT(motor.speed, 500);
  EXPECT_LT(pid.integral, 2 * pid.limit);
  // It leaves the bound and settles at once; wound up it would stay at full speed for seconds.
  for (int i = 0; i < 5000; ++i) motor.step(pid.step(200, motor.speed, kPeriod), kPeriod);
  EXPECT_NEAR(motor.speed, 200, 1);
}

TEST(Pid, WindsUpWithoutTracking) {
  Motor motor;
  Pid pid{.tracking = 1e9};
  for (int i = 0; i < 10000; ++i) motor.step(pid.step(600, motor.speed, kPeriod), kPeriod);
  for (int i = 0; i < 5000; ++i) motor.step(pid.step(200, motor.speed, kPeriod), kPeriod);
  EXPECT_GT(motor.speed, 250);
}

TEST(Pid, DoesNotKickItsDerivativeOnASetPointStep) {
  Pid pid{.gain = 0, .integral_gain = 0, .derivative_gain = 0.001};
  EXPECT_EQ(pid.step(0, 0, kPeriod), 0);
  EXPECT_EQ(pid.step(100, 0, kPeriod), 0);
  EXPECT_LT(pid.step(100, 1, kPeriod), 0);
}

TEST(ErrorMeter, KeepsTheLargest) {
  ErrorMeter meter;
  meter.step(1, kPeriod);
  meter.step(-3, kPeriod);
  meter.step(2, kPeriod);
  EXPECT_EQ(meter.largest, 3);
}

TEST(ErrorMeter, ComesToTheMeanSquareOfASteadyError) {
  ErrorMeter meter;
  for (int i = 0; i < 100000; ++i) meter.step(i % 2 == 0 ? 2 : -2, kPeriod);
  EXPECT_NEAR(std::sqrt(meter.mean_square), 2, 0.001);
}

}  // namespace
}  // namespace control2
