#include "arm_model/search.hpp"

#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <motion.hpp>

namespace {

using arm_model::Joints;
using arm_model::kAxes;
using arm_model::Kinematics;
using arm_model::Reach;
using arm_model::Search;

constexpr double kPi = std::numbers::pi;

Joints home() { return arm_model::home(arm_model::built_in()); }

double distance(const KDL::Frame& one, const KDL::Frame& other) {
  const KDL::Twist twist = KDL::diff(one, other);
  return std::max(twist.vel.Norm(), twist.rot.Norm());
}

struct Answer {
  Reach reach = Reach::searching;
  int steps = 0;
};
Answer search(Search& search, const KDL::Frame& goal, const Joints& near) {
  search.begin(goal, near);
  Answer answer;
  while (answer.reach == Reach::searching) {
    answer.reach = search.step();
    ++answer.steps;
  }
  return answer;
}

TEST(Kinematics, FindsTheToolPointingDownAtHome) {
  Kinematics kinematics{arm_model::built_in()};
  const arm_model::Pose pose = arm_model::pose(kinematics.forward(home()));
  EXPECT_NEAR(pose.x, 0.16 + 0.64, 1e-12);
  EXPECT_NEAR(pose.y, 0, 1e-12);
  EXPECT_NEAR(pose.z, 0.45 + 0.6 + 0.12 - 0.25, 1e-12);
  EXPECT_NEAR(std::abs(pose.roll), kPi, 1e-9);
  EXPECT_NEAR(pose.pitch, 0, 1e-9);
  EXPECT_NEAR(pose.yaw, 0, 1e-9);
}

TEST(Kinematics, RollsFirstAndThenYawsAboutFixedAxes) {
  // A quarter turn about x moves z to -y. A quarter turn about z then moves -y to x.
  const KDL::Frame frame = arm_model::frame({.roll = kPi / 2, .yaw = kPi / 2});
  EXPECT_LT((frame.M.UnitZ() - KDL::Vector{1, 0, 0}).Norm(), 1e-12);
  const arm_model::Pose back = arm_model::pose(frame);
  EXPECT_NEAR(back.roll, kPi / 2, 1e-9);
  EXPECT_NEAR(back.yaw, kPi / 2, 1e-9);
}

TEST(Kinematics, ComputesAJacobianThatMatchesFiniteDifferences) {
  Kinematics kinematics{arm_model::built_in()};
  const Joints at{0.3, 0.4, -0.2, 0.5, 1.1, -0.7};
  const arm_model::Matrix6 jacobian = kinematics.jacobian(at);
  for (std::size_t i = 0; i < kAxes; ++i) {
    Joints moved = at;
    moved[i] += 1e-6;
    const KDL::Twist twist = KDL::diff(kinematics.forward(at), kinematics.forward(moved), 1e-6);
    for (int row = 0; row < 6; ++row)
      EXPECT_NEAR(jacobian(row, static_cast<int>(i)), twist(row), 1e-5) << "axis " << i;
  }
}

TEST(Kinematics, HasNoDexterityWhenTwoAxesAreAligned) {
  Kinematics kinematics{arm_model::built_in()};
  EXPECT_GT(Kinematics::dexterity(kinematics.jacobian(home())), 0.1);
  EXPECT_LT(Kinematics::dexterity(kinematics.jacobian({0.2, 0.3, 0.1, 0.4, 0, 0.5})), 1e-6);
}

TEST(Search, FindsThousandsOfReachablePoses) {
  Kinematics kinematics{arm_model::built_in()};
  Search here{kinematics};
  std::mt19937 random{1};
  int most = 0;
  long all = 0;
  constexpr int kPoses = 5000;
  for (int n = 0; n < kPoses; ++n) {
    Joints joints{};
    for (std::size_t i = 0; i < kAxes; ++i) {
      const arm_model::Axis& axis = arm_model::built_in()[i];
      joints[i] = std::uniform_real_distribution{axis.lower, axis.upper}(random);
    }
    const KDL::Frame goal = kinematics.forward(joints);
    const Answer answer = search(here, goal, home());
    ASSERT_EQ(answer.reach, Reach::found) << "pose " << n;
    EXPECT_LT(distance(kinematics.forward(here.found()), goal), 1e-6) << "pose " << n;
    for (std::size_t i = 0; i < kAxes; ++i) {
      EXPECT_GE(here.found()[i], arm_model::built_in()[i].lower) << "pose " << n << " axis " << i;
      EXPECT_LE(here.found()[i], arm_model::built_in()[i].upper) << "pose " << n << " axis " << i;
    }
    most = std::max(most, answer.steps);
    all += answer.steps;
  }
  std::printf("searched %d poses: %.1f steps on average, at most %d\n", kPoses, double(all) / kPoses, most);
  EXPECT_LT(most, int(Search::kStarts) * Search::kStepsPerStart);
}

TEST(Search, FindsTheSolutionNearestToTheStartingAxes) {
  Kinematics kinematics{arm_model::built_in()};
  Search here{kinematics};
  Joints near = home();
  const Joints wanted{0.1, 0.05, 0.1, 0.1, 1.5, -0.1};
  ASSERT_EQ(search(here, kinematics.forward(wanted), near).reach, Reach::found);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_NEAR(here.found()[i], wanted[i], 1e-6) << "axis " << i;
}

TEST(Search, ReportsWhyItFindsNoSolution) {
  Kinematics kinematics{arm_model::built_in()};
  Search here{kinematics};
  const Answer far = search(here, arm_model::frame({.x = 2, .z = 0.5, .roll = kPi}), home());
  EXPECT_EQ(far.reach, Reach::out_of_reach);
  std::printf("search reported out of reach after %d steps\n", far.steps);

  arm_model::Parameters narrow = arm_model::built_in();
  narrow[0].lower = -0.2;
  narrow[0].upper = 0.2;
  narrow[1].lower = -0.5;
  narrow[1].upper = 0.5;
  Kinematics cannot_turn{narrow};
  Search there{cannot_turn};
  const Answer beside = search(there, arm_model::frame({.x = 0.4, .y = 0.7, .z = 0.5, .roll = kPi}), home());
  EXPECT_EQ(beside.reach, Reach::joint_limit);
}

TEST(Search, GivesTheSameResultEachTime) {
  Kinematics kinematics{arm_model::built_in()};
  const KDL::Frame goal = arm_model::frame({.x = 0.4, .y = -0.6, .z = 0.3, .roll = kPi, .yaw = 2});
  Search one{kinematics};
  Search other{kinematics};
  const Answer first = search(one, goal, home());
  EXPECT_EQ(search(other, goal, home()).steps, first.steps);
  EXPECT_EQ(one.found(), other.found());
}

std::string problem(const std::string& text) {
  const std::string file = testing::TempDir() + "arm_parameters.json";
  std::ofstream{file} << text;
  const auto read = arm_model::read(file);
  return std::holds_alternative<std::string>(read) ? std::get<std::string>(read) : "";
}

std::string axes(const std::string& last) {
  const std::string good =
      R"({"a":0.1,"alpha":0,"d":0.2,"theta":0,"lower":-3,"upper":3,"velocity":2,"acceleration":9,"torque":99,)"
      R"("home":0.5,"mass":4,"centre":[0,0,0.1],"inertia":[0.1,0.2,0.3],"rotor":1,"viscous":2,"dry":3)";
  std::string text = R"({"axes":[)";
  for (int i = 0; i < 5; ++i) text += good + "},";
  return text + good + last + "}]}";
}

TEST(ArmParameters, AreReadFromAJsonFile) {
  EXPECT_EQ(problem(axes("")), "");
  const auto read = arm_model::read(testing::TempDir() + "arm_parameters.json");
  EXPECT_EQ(std::get<arm_model::Parameters>(read)[5].d, 0.2);
  EXPECT_EQ(std::get<arm_model::Parameters>(read)[5].centre[2], 0.1);
  EXPECT_EQ(std::get<arm_model::Parameters>(arm_model::read(""))[0].a, arm_model::built_in()[0].a);
}

TEST(ArmParameters, NameTheMemberInEachErrorMessage) {
  using testing::HasSubstr;
  EXPECT_THAT(std::get<std::string>(arm_model::read("/no/such.json")),
              HasSubstr("no/such.json: cannot be read"));
  EXPECT_THAT(problem("{"), HasSubstr("arm_parameters.json: "));
  EXPECT_THAT(problem(R"({"axes":[]})"), HasSubstr("six objects"));
  EXPECT_THAT(problem(axes(R"(,"mas":3)")), HasSubstr("axes[5].mas: unknown member"));
  EXPECT_THAT(problem(axes(R"(,"mass":-3)")), HasSubstr("axes[5].mass: must be a number of at least 0"));
  EXPECT_THAT(problem(axes(R"(,"rotor":0)")), HasSubstr("axes[5].rotor: must be a number above 0"));
  EXPECT_THAT(problem(axes(R"(,"upper":-4)")), HasSubstr("axes[5].lower: must be below upper"));
  EXPECT_THAT(problem(axes(R"(,"home":4)")), HasSubstr("axes[5].home"));
  EXPECT_THAT(problem(axes(R"(,"centre":[1,2])")), HasSubstr("axes[5].centre: must be three numbers"));
  EXPECT_THAT(problem(R"({"axes":[{},{},{},{},{},{}]})"), HasSubstr("axes[0].a: is missing"));
}

TEST(KinematicsModule, WritesOnePosePerNewSample) {
  takt::testing::Module module;
  auto& joints = module.in<motion::JointState>("joints");
  auto& pose = module.out<motion::Pose>("pose");
  ASSERT_TRUE(module.start());
  module.step(3);
  EXPECT_EQ(pose.count(), 0U);
  motion::JointState state;
  state.position() = home();
  joints.write(state);
  module.step(3);
  ASSERT_EQ(pose.count(), 1U);
  EXPECT_NEAR(pose.value().x(), 0.8, 1e-12);
  EXPECT_NEAR(pose.value().z(), 0.92, 1e-12);
}

TEST(KinematicsModule, RejectsAMissingModelFile) {
  takt::testing::Module module;
  ASSERT_TRUE(module.set("model", "no_such_arm.json"));
  EXPECT_THAT(module.start().text(), testing::HasSubstr("no_such_arm.json: cannot be read"));
}

}  // namespace
