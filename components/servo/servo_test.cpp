#include "joint_servo.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <motion.hpp>

#include "arm/rigid_arm.hpp"
#include "trajectory/whole_plan.hpp"

namespace {

using arm_model::Joints;
using arm_model::kAxes;
using trajectory::Path;
using trajectory::Planner;
using trajectory::Step;
using trajectory::WholePlan;

constexpr double kPeriod = 1e-3;

const arm_model::Parameters& figures() { return arm_model::built_in(); }
Joints home() { return arm_model::home(figures()); }

KDL::Frame down(double x, double y, double z, double yaw = 0) {
  return arm_model::frame({.x = x, .y = y, .z = z, .roll = std::numbers::pi, .yaw = yaw});
}
WholePlan plan(const KDL::Frame& pick, const KDL::Frame& place) {
  return trajectory::whole_plan(figures(), trajectory::usual_task(figures(), pick, place));
}

TEST(JointServo, NeverExceedsTheTorqueLimitsOfTheDrives) {
  servo::JointServo servo{figures()};
  servo::Motion far{home(), {}};
  for (double& position : far.position) position += 3;
  const Joints torque = servo.torque(far, far, {home(), {}}, kPeriod);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_LE(std::abs(torque[i]), figures()[i].torque);
  EXPECT_EQ(torque[1], figures()[1].torque);
}

// The results of follow(), which runs path, servo and arm together. The servo reads the measurement of the
// previous period, as it does in a cell in which the servo runs before the arm.
struct Followed {
  double axis = 0;     // rad, largest error of an axis
  double tool = 0;     // m, largest error on the whole path
  double at_part = 0;  // m, largest error when the gripper has closed or opened
  double torque = 0;   // largest torque, as a fraction of the drive's limit
};
Followed follow(const WholePlan& planned, const std::function<void(servo::JointServo&)>& change = {},
                double load = 0) {
  EXPECT_EQ(planned.state, Planner::State::planned);
  arm_model::Kinematics kinematics{figures()};
  servo::JointServo servo{figures()};
  if (change) change(servo);
  arm_model::Parameters loaded = figures();
  loaded[5].mass += load;
  arm::RigidArm arm{loaded};
  Path path{home()};
  path.begin(*planned.plan, Step::to_pick);
  servo::Motion last{home(), {}};
  servo::Motion measured = last;
  Followed result;
  while (path.busy()) {
    path.advance(true, Path::most_acceleration(figures()), kPeriod);
    const servo::Motion wanted{path.position(), path.velocity()};
    const Joints torque = servo.torque(wanted, last, measured, kPeriod);
    last = wanted;
    arm.step(torque, kPeriod);
    measured = {arm.position, arm.velocity};
    for (std::size_t i = 0; i < kAxes; ++i) {
      result.axis = std::max(result.axis, std::abs(wanted.position[i] - arm.position[i]));
      result.torque = std::max(result.torque, std::abs(torque[i]) / figures()[i].torque);
    }
    const double off = (kinematics.forward(wanted.position).p - kinematics.forward(arm.position).p).Norm();
    result.tool = std::max(result.tool, off);
    if (path.ended().any && (path.ended().step == Step::grip || path.ended().step == Step::release))
      result.at_part = std::max(result.at_part, off);
  }
  return result;
}

TEST(JointServo, FollowsAWholeCycleWithinATenthOfAMillimetre) {
  const Followed followed = follow(plan(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2, 1)));
  std::printf(
      "largest errors: axis %.2g rad, tool %.2g m, tool when it grips or releases a part %.2g m; torque %.2f "
      "of the limit\n",
      followed.axis, followed.tool, followed.at_part, followed.torque);
  EXPECT_LT(followed.tool, 1e-4);
  EXPECT_LT(followed.at_part, 1e-6);
  EXPECT_LT(followed.torque, 1);
}

TEST(JointServo, GripsAndReleasesWithinAMillimetreDespiteAnUnknownLoad) {
  const Followed followed = follow(plan(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2, 1)), {}, 5);
  std::printf(
      "largest errors with a load of 5 kg: tool %.2g m, tool when it grips or releases a part %.2g m\n",
      followed.tool, followed.at_part);
  EXPECT_LT(followed.tool, 3e-3);
  EXPECT_LT(followed.at_part, 1e-3);
  EXPECT_GT(followed.at_part, 1e-5) << "the load has no effect";
}

TEST(JointServo, IsLessAccurateWithoutItsFeedForwardTerms) {
  const WholePlan way = plan(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2, 1));
  const Followed with = follow(way);
  const Followed without_gravity = follow(way, [](servo::JointServo& servo) { servo.gravity = false; });
  const Followed without_acceleration =
      follow(way, [](servo::JointServo& servo) { servo.acceleration = false; });
  EXPECT_GT(without_gravity.at_part, 2e-4);
  EXPECT_LT(with.at_part, 1e-6);
  EXPECT_GT(without_acceleration.tool, 20 * with.tool);
}

// The tests below run the whole module on virtual time.

motion::JointState state(const Joints& position) {
  motion::JointState state;
  state.position() = position;
  return state;
}

TEST(Servo, WritesNothingUntilBothInputsHaveArrived) {
  takt::testing::Module module;
  auto& setpoint = module.in<motion::JointState>("setpoint");
  auto& measured = module.in<motion::JointState>("measured");
  auto& effort = module.out<motion::JointEffort>("effort");
  ASSERT_TRUE(module.start());
  setpoint.write(state(home()));
  module.step(5);
  EXPECT_EQ(effort.count(), 0U);
  measured.write(state(home()));
  module.step(5);
  EXPECT_EQ(effort.count(), 5U);
  EXPECT_GT(std::abs(effort.value().torque()[1]), 50) << "the torque does not carry the weight of the arm";
}

TEST(Servo, FailsIfASetPointIsTooFarAwayOrNotFinite) {
  for (const double wrong : {0.2, std::numeric_limits<double>::quiet_NaN()}) {
    takt::testing::Module module;
    auto& setpoint = module.in<motion::JointState>("setpoint");
    auto& measured = module.in<motion::JointState>("measured");
    auto& effort = module.out<motion::JointEffort>("effort");
    ASSERT_TRUE(module.start());
    Joints off = home();
    off[3] += wrong;
    setpoint.write(state(off));
    measured.write(state(home()));
    module.step();
    EXPECT_EQ(module.last_error().text, "an axis does not follow its set point");
    EXPECT_EQ(effort.count(), 0U);
  }
}

}  // namespace
