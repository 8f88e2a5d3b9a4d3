#include "whole_plan.hpp"

#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <tuple>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <basic.hpp>
#include <motion.hpp>

namespace trajectory {
namespace {

constexpr double kPeriod = 1e-3;

const arm_model::Parameters& figures() { return arm_model::built_in(); }
Joints home() { return arm_model::home(figures()); }

KDL::Frame down(double x, double y, double z, double yaw = 0) {
  return arm_model::frame({.x = x, .y = y, .z = z, .roll = std::numbers::pi, .yaw = yaw});
}
WholePlan plan(const KDL::Frame& pick, const KDL::Frame& place) {
  return whole_plan(figures(), usual_task(figures(), pick, place));
}

// The largest velocities and accelerations of a motion, from the changes between periods and from the
// velocity that the path reports.
struct Extremes {
  double velocity = 0;  // fraction of the limit
  double acceleration = 0;
  double disagreement = 0;  // rad, difference between the moved distance and the reported velocity
  int periods = 0;
  Joints last{};
  Joints last_velocity{};

  void see(const Path& path) {
    for (std::size_t i = 0; i < kAxes; ++i) {
      const double moved = (path.position()[i] - last[i]) / kPeriod;
      const double change = (path.velocity()[i] - last_velocity[i]) / kPeriod;
      velocity = std::max({velocity, std::abs(moved) / figures()[i].velocity,
                           std::abs(path.velocity()[i]) / figures()[i].velocity});
      acceleration = std::max(acceleration, std::abs(change) / figures()[i].acceleration);
      disagreement =
          std::max(disagreement, std::abs(moved - (path.velocity()[i] + last_velocity[i]) / 2) * kPeriod);
      EXPECT_GE(path.position()[i], figures()[i].lower);
      EXPECT_LE(path.position()[i], figures()[i].upper);
    }
    last = path.position();
    last_velocity = path.velocity();
    ++periods;
  }
};

Extremes run(const Plan& plan, const std::function<bool(int)>& enabled,
             const std::function<void(Path&)>& each = {}) {
  Path path{home()};
  Extremes extremes{.last = home()};
  path.begin(plan, Step::to_pick);
  while (path.busy() && extremes.periods < 60000) {
    path.advance(enabled(extremes.periods), Path::most_acceleration(figures()), kPeriod);
    extremes.see(path);
    if (each) each(path);
  }
  EXPECT_FALSE(path.busy());
  EXPECT_EQ(path.position(), home());
  return extremes;
}

void expect_within_limits(const Extremes& extremes) {
  EXPECT_LE(extremes.velocity, 1);
  EXPECT_LE(extremes.acceleration, 1);
  EXPECT_LT(extremes.disagreement, 1e-5);
}

// A random pose in front of the arm, or on either side, where the arm can pick and place.
KDL::Frame anywhere(std::mt19937& random) {
  const double angle = std::uniform_real_distribution{-1.8, 1.8}(random);
  const double radius = std::uniform_real_distribution{0.55, 1.0}(random);
  return down(radius * std::cos(angle), radius * std::sin(angle),
              std::uniform_real_distribution{0.1, 0.5}(random),
              angle + std::uniform_real_distribution{-1.2, 1.2}(random));
}

TEST(Plan, KeepsEveryAxisWithinItsLimits) {
  std::mt19937 random{2};
  double longest = 0;
  int planning = 0;
  int rejected = 0;
  for (int n = 0; n < 150; ++n) {
    const WholePlan planned = plan(anywhere(random), anywhere(random));
    // Some poses are singular, because the forearm points down.
    if (planned.state == Planner::State::singular && ++rejected > 0) continue;
    ASSERT_EQ(planned.state, Planner::State::planned) << "pair " << n;
    const Extremes extremes = run(*planned.plan, [](int) { return true; });
    expect_within_limits(extremes);
    EXPECT_NEAR(extremes.periods * kPeriod, planned.plan->until(Step::home), 2 * kPeriod);
    longest = std::max(longest, planned.plan->until(Step::home));
    planning = std::max(planning, planned.periods);
  }
  std::printf("150 cycles: longest cycle %.2f s, longest planning %d periods, %d requests rejected\n",
              longest, planning, rejected);
  EXPECT_LT(rejected, 8);
}

TEST(Plan, MovesTheToolOnAStraightLineAboveThePart) {
  arm_model::Kinematics kinematics{figures()};
  const KDL::Frame pick = down(0.75, 0.45, 0.3, 0.4);
  const WholePlan planned = plan(pick, down(0.5, -0.7, 0.2));
  ASSERT_EQ(planned.state, Planner::State::planned);
  double off = 0;
  for (int n = 0; n <= 1000; ++n) {
    const double s = n / 1000.0;
    const KDL::Frame wanted{pick.M, pick.p + KDL::Vector{0, 0, 0.15} * s};
    const KDL::Twist twist = KDL::diff(kinematics.forward(planned.plan->pick.at(s).position), wanted);
    off = std::max({off, twist.vel.Norm(), twist.rot.Norm()});
  }
  std::printf("largest deviation from a line of 0.15 m: %.2g m or rad\n", off);
  EXPECT_LT(off, 1e-5);
}

TEST(Plan, BringsTheToolToTheRequestedPoses) {
  arm_model::Kinematics kinematics{figures()};
  const KDL::Frame pick = down(0.75, 0.45, 0.3, 0.4);
  const KDL::Frame place = down(0.5, -0.7, 0.2, -1);
  const WholePlan planned = plan(pick, place);
  ASSERT_EQ(planned.state, Planner::State::planned);
  const auto off = [&](Step step, const KDL::Frame& wanted) {
    const KDL::Twist twist = KDL::diff(kinematics.forward(planned.plan->leg(step).from), wanted);
    return std::max(twist.vel.Norm(), twist.rot.Norm());
  };
  EXPECT_LT(off(Step::grip, pick), 1e-8);
  EXPECT_LT(off(Step::release, place), 1e-8);
}

TEST(Path, KeepsItsLimitsWhenDisabledAtAnyTime) {
  const WholePlan planned = plan(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2, 1));
  ASSERT_EQ(planned.state, Planner::State::planned);
  // In each run, disable the motion for 0.7 s. The start of this pause moves by 40 periods from run to run.
  const int whole = static_cast<int>(planned.plan->until(Step::home) / kPeriod);
  int slowest = 0;
  for (int at = 1; at + 400 < whole; at += 40) {
    int held = 0;
    int rested = 0;
    const Extremes extremes = run(
        *planned.plan, [&](int n) { return n < at || n >= at + 700; },
        [&, n = 0](Path& path) mutable {
          ++n;
          if (n <= at || n > at + 700) return;
          ++held;
          if (path.velocity() == Joints{}) ++rested;
        });
    expect_within_limits(extremes);
    EXPECT_GT(rested, 100) << "held at " << at;
    slowest = std::max(slowest, held - rested);
  }
  std::printf("longest time to come to rest: %d ms\n", slowest);
}

TEST(Path, KeepsItsLimitsForRandomEnableChanges) {
  std::mt19937 random{3};
  for (int n = 0; n < 40; ++n) {
    const WholePlan planned = plan(anywhere(random), anywhere(random));
    if (planned.state != Planner::State::planned) continue;
    bool on = true;
    const Extremes extremes = run(*planned.plan, [&](int period) {
      if (period > 30000) return true;
      if (std::uniform_int_distribution{0, 60}(random) == 0) on = !on;
      return on;
    });
    expect_within_limits(extremes);
  }
}

TEST(Path, DoesNotLeaveItsStartWhileDisabled) {
  const WholePlan planned = plan(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2));
  Path path{home()};
  for (int n = 0; n < 1000; ++n) path.advance(false, Path::most_acceleration(figures()), kPeriod);
  path.begin(*planned.plan, Step::to_pick);
  for (int n = 0; n < 1000; ++n) path.advance(false, Path::most_acceleration(figures()), kPeriod);
  EXPECT_EQ(path.position(), home());
  EXPECT_TRUE(path.busy());
}

TEST(Path, GoesHomeFromAboveThePartAfterGiveUp) {
  const WholePlan planned = plan(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2));
  ASSERT_EQ(planned.state, Planner::State::planned);
  std::vector<Step> ended;
  const Extremes extremes = run(
      *planned.plan, [](int) { return true; },
      [&](Path& path) {
        if (path.busy() && path.step() == Step::up) path.give_up();
        if (path.ended().any) ended.push_back(path.ended().step);
      });
  expect_within_limits(extremes);
  EXPECT_EQ(ended, (std::vector{Step::to_pick, Step::down, Step::grip, Step::up, Step::give_up}));
}

TEST(Planner, RejectsImpossiblePoses) {
  const KDL::Frame good = down(0.75, 0.45, 0.3);
  for (const auto& [state, bad, why] :
       std::initializer_list<std::tuple<Planner::State, KDL::Frame, const char*>>{
           {Planner::State::out_of_reach, down(2, 0, 0.3), "too far"},
           {Planner::State::out_of_reach, down(0.8, 0, -1.5), "too low"},
           // The wrist is at 1.2505 m; upper arm and forearm together are 1.2512 m long.
           {Planner::State::singular, down(0.16 + 1.2505, 0, 0.2), "stretched"}}) {
    const WholePlan pick = plan(bad, good);
    EXPECT_EQ(pick.state, state) << "pick " << why << " in " << pick.periods;
    const WholePlan place = plan(good, bad);
    EXPECT_EQ(place.state, state) << "place " << why << " in " << place.periods;
    std::printf("%s: rejected after %d periods\n", why, place.periods);
  }
}

// The tests below run the whole module on virtual time.

motion::Pose pose(double x, double y, double z) {
  motion::Pose pose;
  pose.x(x);
  pose.y(y);
  pose.z(z);
  pose.roll(std::numbers::pi);
  return pose;
}
motion::PickRequest from_here_to_there(std::uint32_t number) {
  motion::PickRequest request;
  request.number(number);
  request.pick() = pose(0.75, 0.45, 0.3);
  request.place() = pose(0.5, -0.7, 0.2);
  return request;
}
basic::Flag flag(bool value) {
  basic::Flag flag;
  flag.value(value);
  return flag;
}

class Trajectory : public testing::Test {
 protected:
  takt::testing::Module module;
  takt::testing::In<motion::PickRequest>& request = module.in<motion::PickRequest>("request", {.queue = 8});
  takt::testing::Out<motion::JointState>& setpoint = module.out<motion::JointState>("setpoint");
  takt::testing::Out<basic::Flag>& grip = module.out<basic::Flag>("grip");
  takt::testing::Out<motion::PickPlan>& times = module.out<motion::PickPlan>("plan");
  takt::testing::Out<motion::PickDone>& done = module.out<motion::PickDone>("done");

  // Steps the module until it writes a result, and checks the velocity of every axis in every period.
  void step_until_done() {
    Joints last = setpoint.has_value() ? setpoint.value().position() : home();
    const std::uint64_t before = done.count();
    const bool came = module.step_until(
        [&] {
          for (std::size_t i = 0; i < kAxes; ++i)
            EXPECT_LE(std::abs(setpoint.value().position()[i] - last[i]), figures()[i].velocity * kPeriod);
          last = setpoint.value().position();
          return done.count() > before;
        },
        20000);
    ASSERT_TRUE(came) << module.healthy().text();
  }
};

TEST_F(Trajectory, PlacesThePartAtTheAnnouncedTime) {
  ASSERT_TRUE(module.start());
  module.step(10);
  EXPECT_EQ(setpoint.value().position(), home());
  request.write(from_here_to_there(7));
  step_until_done();
  EXPECT_EQ(done.value().number(), 7U);
  EXPECT_EQ(done.value().result(), motion::PICK_PLACED);
  ASSERT_EQ(times.count(), 1U);
  EXPECT_NEAR(times.value().placed(), done.value().duration(), 2 * kPeriod);
  EXPECT_GT(times.value().ended(), times.value().placed());
  const double left = times.value().ended() - done.value().duration();
  module.step(static_cast<std::uint64_t>(left / kPeriod) + 3);
  EXPECT_EQ(setpoint.value().position(), home());
  std::printf("placed after %.3f s, home after %.3f s\n", times.value().placed(), times.value().ended());
}

TEST_F(Trajectory, ClosesTheGripperAtThePartAndOpensItAtThePlace) {
  arm_model::Kinematics kinematics{figures()};
  ASSERT_TRUE(module.start());
  request.write(from_here_to_there(1));
  bool closed = false;
  int changes = 0;
  ASSERT_TRUE(module.step_until(
      [&] {
        if (grip.value().value() != closed) {
          closed = grip.value().value();
          ++changes;
          const KDL::Vector at = kinematics.forward(setpoint.value().position()).p;
          const KDL::Vector wanted = closed ? KDL::Vector{0.75, 0.45, 0.3} : KDL::Vector{0.5, -0.7, 0.2};
          EXPECT_LT((at - wanted).Norm(), 1e-6);
        }
        return done.count() == 1;
      },
      20000));
  EXPECT_EQ(changes, 2);
}

TEST_F(Trajectory, AnswersARepeatedRequestForAPlacedPartAtOnce) {
  ASSERT_TRUE(module.start());
  request.write(from_here_to_there(1));
  request.write(from_here_to_there(1));
  step_until_done();
  module.step(2000);
  EXPECT_EQ(done.count(), 2U);
  EXPECT_EQ(times.count(), 1U);
  EXPECT_EQ(done.value().number(), 1U);
}

TEST_F(Trajectory, StaysAtHomeWhenItRejectsAnImpossibleRequest) {
  ASSERT_TRUE(module.start());
  motion::PickRequest far = from_here_to_there(1);
  far.pick().x(2);
  motion::PickRequest none = from_here_to_there(2);
  none.place().yaw(std::numeric_limits<double>::quiet_NaN());
  motion::PickRequest stretched = from_here_to_there(3);
  stretched.place() = pose(0.16 + 1.2505, 0, 0.2);
  for (const auto& [asked, why] :
       {std::pair{far, motion::REFUSAL_OUT_OF_REACH}, std::pair{none, motion::REFUSAL_NO_POSE},
        std::pair{stretched, motion::REFUSAL_SINGULARITY}}) {
    request.write(asked);
    step_until_done();
    EXPECT_EQ(done.value().number(), asked.number());
    EXPECT_EQ(done.value().result(), motion::PICK_REFUSED);
    EXPECT_EQ(done.value().refusal(), why);
    EXPECT_EQ(setpoint.value().position(), home());
  }
  EXPECT_EQ(times.count(), 0U);
  request.write(from_here_to_there(4));
  step_until_done();
  EXPECT_EQ(done.value().result(), motion::PICK_PLACED);
}

TEST_F(Trajectory, WaitsOnThePathWhileDisabled) {
  auto& enable = module.in<basic::Flag>("enable");
  ASSERT_TRUE(module.start());
  request.write(from_here_to_there(1));
  module.step(500);
  enable.write(flag(false));
  module.step(500);
  EXPECT_EQ(setpoint.value().velocity(), (std::array<double, kAxes>{}));
  const auto held = setpoint.value().position();
  EXPECT_NE(held, home());
  module.step(3000);
  EXPECT_EQ(setpoint.value().position(), held);
  EXPECT_EQ(done.count(), 0U);
  enable.write(flag(true));
  step_until_done();
  EXPECT_EQ(done.value().result(), motion::PICK_PLACED);
  EXPECT_GT(done.value().duration(), times.value().placed() + 3);
}

TEST_F(Trajectory, GoesHomeWhenTheGripperMissesThePart) {
  auto& holding = module.in<basic::Flag>("holding");
  ASSERT_TRUE(module.start());
  holding.write(flag(false));
  request.write(from_here_to_there(1));
  step_until_done();
  EXPECT_EQ(done.value().result(), motion::PICK_LOST);
  EXPECT_EQ(setpoint.value().position(), home());
  EXPECT_FALSE(grip.value().value());
  // If the requester repeats the request, the arm tries again.
  request.write(from_here_to_there(1));
  ASSERT_TRUE(module.step_until([&] { return grip.value().value(); }, 5000));
  holding.write(flag(true));
  step_until_done();
  EXPECT_EQ(done.value().result(), motion::PICK_PLACED);
}

TEST_F(Trajectory, ReportsAPartThatFellOnTheWay) {
  auto& holding = module.in<basic::Flag>("holding");
  ASSERT_TRUE(module.start());
  holding.write(flag(true));
  request.write(from_here_to_there(1));
  ASSERT_TRUE(module.step_until([&] { return grip.value().value(); }, 5000));
  module.step(1200);  // the arm is now on its way to the target place
  holding.write(flag(false));
  step_until_done();
  EXPECT_EQ(done.value().result(), motion::PICK_LOST);
}

TEST_F(Trajectory, BeginsAtTheMeasuredPositionOfTheArm) {
  auto& measured = module.in<motion::JointState>("measured");
  ASSERT_TRUE(module.start());
  module.step(10);
  EXPECT_FALSE(setpoint.has_value());
  motion::JointState state;
  state.position() = home();
  state.position()[0] = -1;
  measured.write(state);
  module.step();
  EXPECT_NEAR(setpoint.value().position()[0], -1, 1e-3);
  module.step(3000);
  EXPECT_EQ(setpoint.value().position(), home());
}

TEST_F(Trajectory, MovesABlockedArmHomeFromItsMeasuredPosition) {
  auto& measured = module.in<motion::JointState>("measured");
  motion::JointState state;
  state.position() = home();
  measured.write(state);
  ASSERT_TRUE(module.start());
  const auto follow = [&] {  // imitates an arm that follows one period later
    state = setpoint.value();
    measured.write(state);
    return done.count() > 0;
  };
  request.write(from_here_to_there(1));
  module.step_until(follow, 500);
  ASSERT_EQ(done.count(), 0U);
  const auto stand = [&] {
    measured.write(state);
    return done.count() > 0;
  };
  ASSERT_TRUE(module.step_until(stand, 400));
  EXPECT_EQ(done.value().result(), motion::PICK_LOST);
  for (std::size_t i = 0; i < kAxes; ++i)
    EXPECT_LT(std::abs(setpoint.value().position()[i] - state.position()[i]), 0.1) << "axis " << i;
  EXPECT_FALSE(module.step_until([&] { return follow() && done.count() > 1; }, 3000));
  EXPECT_EQ(setpoint.value().position(), home());
  request.write(from_here_to_there(1));
  EXPECT_TRUE(module.step_until([&] { return follow() && done.count() > 1; }, 8000));
  EXPECT_EQ(done.value().result(), motion::PICK_PLACED);
}

TEST_F(Trajectory, TakesLongerAtALowerSpeed) {
  ASSERT_TRUE(module.set("speed", "0.5"));
  ASSERT_TRUE(module.start());
  request.write(from_here_to_there(1));
  step_until_done();
  const double slow = done.value().duration();
  module.step(5000);
  ASSERT_TRUE(module.set("speed", "1"));
  request.write(from_here_to_there(2));
  step_until_done();
  EXPECT_GT(slow, 1.5 * done.value().duration());
  EXPECT_FALSE(module.set("speed", "0"));
}

}  // namespace
}  // namespace trajectory
