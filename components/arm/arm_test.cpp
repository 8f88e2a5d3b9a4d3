#include "rigid_arm.hpp"

#include <chrono>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <motion.hpp>

#include "servo/joint_servo.hpp"

namespace {

using arm_model::Joints;
using arm_model::kAxes;

constexpr double kPeriod = 1e-3;

const arm_model::Parameters& figures() { return arm_model::built_in(); }
Joints home() { return arm_model::home(figures()); }

// Returns the kinetic and potential energy of all bodies.
double energy(const arm::RigidArm& arm) {
  KDL::Chain chain = arm_model::chain(figures());
  KDL::ChainFkSolverPos_recursive forward{chain};
  KDL::ChainDynParam dynamics{chain, KDL::Vector{0, 0, -9.81}};
  KDL::JntArray at{kAxes};
  KDL::JntSpaceInertiaMatrix mass{kAxes};
  for (std::size_t i = 0; i < kAxes; ++i) at(static_cast<unsigned>(i)) = arm.position[i];
  dynamics.JntToMass(at, mass);
  double sum = 0;
  for (std::size_t i = 0; i < kAxes; ++i)
    for (std::size_t j = 0; j < kAxes; ++j)
      sum +=
          0.5 * arm.velocity[i] * arm.velocity[j] * mass(static_cast<unsigned>(i), static_cast<unsigned>(j));
  for (std::size_t i = 0; i < kAxes; ++i) {
    KDL::Frame frame;
    forward.JntToCart(at, frame, static_cast<int>(i) + 1);
    const auto& centre = figures()[i].centre;
    sum += figures()[i].mass * 9.81 * (frame * KDL::Vector{centre[0], centre[1], centre[2]}).z();
  }
  return sum;
}

TEST(RigidArm, ConservesEnergyInAFreeSwing) {
  arm::RigidArm arm{figures()};
  arm.friction = 0;
  arm.position = {0, 0.3, 0.2, 0, 1, 0};
  const double before = energy(arm);
  const Joints start = arm.position;
  double drift = 0;
  double moved = 0;
  double kinetic_from = before;
  for (int n = 0; n < 600; ++n) {
    arm.step({}, kPeriod);
    bool at_limit = false;
    for (std::size_t i = 0; i < kAxes; ++i) {
      moved = std::max(moved, std::abs(arm.position[i] - start[i]));
      at_limit |= arm.position[i] == figures()[i].lower || arm.position[i] == figures()[i].upper;
    }
    if (at_limit) break;
    drift = std::max(drift, std::abs(energy(arm) - before));
    kinetic_from = energy(arm);
  }
  std::printf("energy drift %.3g J of %.1f J; largest axis motion %.2f rad\n", drift, kinetic_from, moved);
  EXPECT_GT(moved, 0.5);
  EXPECT_LT(drift, 1e-3);
}

TEST(RigidArm, HoldsItsPositionWithGravityCompensation) {
  arm::RigidArm arm{figures()};
  servo::JointServo servo{figures()};
  const servo::Motion rest{arm.position, {}};
  const Joints weight = servo.torque(rest, rest, rest, kPeriod);
  EXPECT_GT(std::abs(weight[1]), 50);
  for (int n = 0; n < 200; ++n) arm.step(weight, kPeriod);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_NEAR(arm.position[i], home()[i], 1e-9);
  for (int n = 0; n < 200; ++n) arm.step({}, kPeriod);
  EXPECT_GT(arm.position[1], home()[1] + 0.01) << "without compensation, the arm must fall forwards";
}

TEST(RigidArm, ComesToRestByFrictionOrBrakes) {
  arm::RigidArm arm{figures()};
  arm.velocity = {2, 0, 0, 0, 0, 4};  // at home, gravity does not turn these two axes
  const Joints weight = servo::JointServo{figures()}.torque({arm.position, {}}, {arm.position, {}},
                                                            {arm.position, {}}, kPeriod);
  for (int n = 0; n < 5000; ++n) arm.step(weight, kPeriod);
  EXPECT_NEAR(arm.velocity[0], 0, 0.05);
  EXPECT_NEAR(arm.velocity[5], 0, 0.05);
  arm.velocity.fill(1);
  for (int n = 0; n < 70; ++n) arm.brake(kPeriod);
  EXPECT_EQ(arm.velocity, Joints{});
}

TEST(RigidArm, StopsAtItsAxisLimits) {
  arm::RigidArm arm{figures()};
  for (int n = 0; n < 5000; ++n) arm.step({900, 1000, 600, 150, 150, 80}, kPeriod);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_LE(arm.position[i], figures()[i].upper);
  EXPECT_EQ(arm.position[0], figures()[0].upper);
}

TEST(RigidArm, FindsTheAxisWhoseFrictionIsTooHighToSimulate) {
  EXPECT_EQ(arm::RigidArm::too_stiff(figures()), kAxes);
  arm_model::Parameters stiff = figures();
  stiff[3].dry = 200;
  EXPECT_EQ(arm::RigidArm::too_stiff(stiff), 3U);
}

// The tests below run the whole module on virtual time.

TEST(Arm, AppliesItsBrakesWhileNoEffortsArrive) {
  takt::testing::Module module;
  auto& effort = module.in<motion::JointEffort>("effort");
  auto& measured = module.out<motion::JointState>("measured");
  ASSERT_TRUE(module.start());
  module.step(1000);
  EXPECT_EQ(measured.value().position(), home());

  motion::JointEffort turn;
  turn.torque()[0] = 100;
  effort.write(turn);
  module.step(20);
  EXPECT_GT(measured.value().velocity()[0], 0.02);
  module.step(500);  // the module gets no efforts during these cycles
  EXPECT_EQ(measured.value().velocity(), (std::array<double, kAxes>{}));
  const auto at = measured.value().position();
  module.step(500);
  EXPECT_EQ(measured.value().position(), at);
}

TEST(Arm, KeepsItsStateAfterANonFiniteEffort) {
  takt::testing::Module module;
  auto& effort = module.in<motion::JointEffort>("effort");
  auto& measured = module.out<motion::JointState>("measured");
  ASSERT_TRUE(module.start());
  motion::JointEffort wrong;
  wrong.torque()[2] = std::numeric_limits<double>::quiet_NaN();
  effort.write(wrong);
  module.step();
  EXPECT_EQ(module.last_error().text, "an effort is not a finite number");
  effort.write({});
  ASSERT_TRUE(module.recover());
  module.step();
  for (const double position : measured.value().position()) EXPECT_TRUE(std::isfinite(position));
}

}  // namespace
