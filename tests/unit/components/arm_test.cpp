#include <components/arm/joints.hpp>
#include <components/servo/joint_servo.hpp>
#include <components/trajectory/path.hpp>

#include <cmath>

#include <gtest/gtest.h>

namespace {

constexpr double kPeriod = 1e-3;

TEST(Path, StaysAtHomeUntilItIsBegun) {
  trajectory::Path path;
  EXPECT_EQ(path.step(kPeriod).position, trajectory::Path::kHome);
  EXPECT_FALSE(path.busy());
}

TEST(Path, PutsThePartDownOnceACycleAndEndsAtHome) {
  trajectory::Path path;
  path.begin(0.02, 0.1);
  int put_down = 0;
  int steps = 0;
  trajectory::Point point;
  while (path.busy()) {
    point = path.step(kPeriod);
    put_down += path.put_down() ? 1 : 0;
    ++steps;
  }
  EXPECT_EQ(put_down, 1);
  EXPECT_NEAR(steps, 500, 1);
  EXPECT_EQ(point.position, trajectory::Path::kHome);
}

TEST(Path, HasNoStepInPositionOrVelocity) {
  trajectory::Path path;
  path.begin(-0.05, 0.2);
  trajectory::Point last = path.step(kPeriod);
  while (path.busy()) {
    const trajectory::Point point = path.step(kPeriod);
    for (std::size_t i = 0; i < trajectory::kAxes; ++i) {
      EXPECT_LT(std::abs(point.position[i] - last.position[i]), 0.02) << "axis " << i;
      EXPECT_LT(std::abs(point.velocity[i] - last.velocity[i]), 0.4) << "axis " << i;
    }
    last = point;
  }
}

TEST(Path, TurnsToWhereThePartLies) {
  for (const double offset : {-0.05, 0.0, 0.05}) {
    trajectory::Path path;
    path.begin(offset, 0.1);
    trajectory::Point point;
    for (int i = 0; i < 200; ++i) point = path.step(kPeriod);  // the end of the second leg
    EXPECT_NEAR(point.position[0], trajectory::Path::kAtPart[0] + offset, 1e-3);
  }
}

TEST(JointModel, ComesToRestWithoutTorque) {
  arm::JointModel joints;
  joints.velocity.fill(2);
  for (int i = 0; i < 20000; ++i) joints.step({}, kPeriod);
  for (const double velocity : joints.velocity) EXPECT_NEAR(velocity, 0, 1e-9);
}

TEST(JointModel, ReachesTheSpeedAtWhichFrictionTakesTheTorque) {
  arm::JointModel joints;
  for (int i = 0; i < 20000; ++i) joints.step({40, 40, 40, 40, 40, 40}, kPeriod);
  for (const double velocity : joints.velocity) EXPECT_NEAR(velocity, 2, 1e-6);
}

TEST(JointServo, NeverAsksForMoreThanItsLimit) {
  const servo::JointServo loop{.limit = 100};
  servo::Joints far{};
  far.fill(3);
  for (const double torque : loop.torque(far, {}, {}, {})) EXPECT_EQ(torque, 100);
}

// The three together, with the delays that they have as modules of one table: set point and measurement of
// the period before.
TEST(JointServo, FollowsAWholeCycleOfTheArm) {
  trajectory::Path path;
  servo::JointServo loop;
  arm::JointModel joints;
  path.begin(0.05, 0.4);
  double largest = 0;
  for (int i = 0; i < 3000; ++i) {
    const trajectory::Point wanted = path.step(kPeriod);
    joints.step(loop.torque(wanted.position, wanted.velocity, joints.position, joints.velocity), kPeriod);
    for (std::size_t a = 0; a < arm::kAxes; ++a)
      largest = std::max(largest, std::abs(wanted.position[a] - joints.position[a]));
  }
  EXPECT_LT(largest, 0.15);  // the module calls 0.3 an error
  for (std::size_t a = 0; a < arm::kAxes; ++a)
    EXPECT_NEAR(joints.position[a], trajectory::Path::kHome[a], 1e-3);
}

}  // namespace
