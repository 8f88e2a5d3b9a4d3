#include <components/arm/rigid_arm.hpp>
#include <components/servo/joint_servo.hpp>
#include <components/trajectory/path.hpp>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace {

using arm_model::Joints;
using arm_model::kAxes;
using trajectory::Path;
using trajectory::Plan;
using trajectory::Planner;
using trajectory::Step;

constexpr double kPeriod = 1e-3;
constexpr double kPi = std::numbers::pi;

const arm_model::Parameters& figures() { return arm_model::built_in(); }

Joints home() {
  Joints joints{};
  for (std::size_t i = 0; i < kAxes; ++i) joints[i] = figures()[i].home;
  return joints;
}

KDL::Frame down(double x, double y, double z, double yaw = 0) {
  return arm_model::frame({.x = x, .y = y, .z = z, .roll = kPi, .yaw = yaw});
}

trajectory::Task task(const KDL::Frame& pick, const KDL::Frame& place) {
  trajectory::Task task;
  task.pick = pick;
  task.place = place;
  for (std::size_t i = 0; i < kAxes; ++i) {
    task.limits.velocity[i] = Path::kVelocityShare * figures()[i].velocity;
    task.limits.acceleration[i] = Path::kPlanShare * figures()[i].acceleration;
  }
  return task;
}

Joints most() {
  Joints most{};
  for (std::size_t i = 0; i < kAxes; ++i) most[i] = Path::kHoldShare * figures()[i].acceleration;
  return most;
}

struct Planned {
  std::unique_ptr<Plan> plan = std::make_unique<Plan>();
  Planner::State state = Planner::State::planning;
  int periods = 0;
};
Planned plan(const trajectory::Task& task) {
  Planner planner{figures()};
  Planned result;
  planner.begin(task, home(), *result.plan);
  while (result.state == Planner::State::planning) {
    result.state = planner.step();
    ++result.periods;
  }
  return result;
}

// By differences from period to period, from the velocity that the path says too.
struct Extremes {
  double velocity = 0;  // shares of the limits
  double acceleration = 0;
  double disagreement = 0;  // rad, of position and velocity
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
    path.advance(enabled(extremes.periods), most(), kPeriod);
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

// In front of the arm, and left and right of it, where it can take and put things.
KDL::Frame anywhere(std::mt19937& random) {
  const double angle = std::uniform_real_distribution{-1.8, 1.8}(random);
  const double radius = std::uniform_real_distribution{0.55, 1.0}(random);
  return down(radius * std::cos(angle), radius * std::sin(angle),
              std::uniform_real_distribution{0.1, 0.5}(random),
              angle + std::uniform_real_distribution{-1.2, 1.2}(random));
}

TEST(Plan, KeepsEveryAxisWithinItsLimitsAndGoesOnWithoutAStep) {
  std::mt19937 random{2};
  double longest = 0;
  int planning = 0;
  int refused = 0;
  for (int n = 0; n < 150; ++n) {
    const Planned planned = plan(task(anywhere(random), anywhere(random)));
    if (planned.state == Planner::State::singular && ++refused > 0) continue;  // the forearm points down
    ASSERT_EQ(planned.state, Planner::State::planned) << "pair " << n;
    const Extremes extremes = run(*planned.plan, [](int) { return true; });
    expect_within_limits(extremes);
    EXPECT_NEAR(extremes.periods * kPeriod, planned.plan->until(Step::home), 2 * kPeriod);
    longest = std::max(longest, planned.plan->until(Step::home));
    planning = std::max(planning, planned.periods);
  }
  std::printf("150 cycles: at most %.2f s, planned in at most %d periods; %d refused\n", longest, planning,
              refused);
  EXPECT_LT(refused, 8);
}

TEST(Plan, IsStraightOverThePartAndThePlace) {
  arm_model::Kinematics kinematics{figures()};
  const KDL::Frame pick = down(0.75, 0.45, 0.3, 0.4);
  const Planned planned = plan(task(pick, down(0.5, -0.7, 0.2)));
  ASSERT_EQ(planned.state, Planner::State::planned);
  double off = 0;
  for (int n = 0; n <= 1000; ++n) {
    const double s = n / 1000.0;
    const KDL::Frame wanted{pick.M, pick.p + KDL::Vector{0, 0, 0.15} * s};
    const KDL::Twist twist = KDL::diff(kinematics.forward(planned.plan->pick.at(s).position), wanted);
    off = std::max({off, twist.vel.Norm(), twist.rot.Norm()});
  }
  std::printf("%.2g m or rad off a line of 0.15 m\n", off);
  EXPECT_LT(off, 1e-5);
}

TEST(Plan, TheToolIsWhereItIsAskedToBe) {
  arm_model::Kinematics kinematics{figures()};
  const KDL::Frame pick = down(0.75, 0.45, 0.3, 0.4);
  const KDL::Frame place = down(0.5, -0.7, 0.2, -1);
  const Planned planned = plan(task(pick, place));
  ASSERT_EQ(planned.state, Planner::State::planned);
  const auto off = [&](Step step, const KDL::Frame& wanted) {
    const KDL::Twist twist = KDL::diff(kinematics.forward(planned.plan->leg(step).from), wanted);
    return std::max(twist.vel.Norm(), twist.rot.Norm());
  };
  EXPECT_LT(off(Step::grip, pick), 1e-8);
  EXPECT_LT(off(Step::release, place), 1e-8);
}

TEST(Path, ComesToRestOnThePathAndGoesOnWithinTheLimits) {
  const Planned planned = plan(task(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2, 1)));
  ASSERT_EQ(planned.state, Planner::State::planned);
  // Held at every fortieth period of the cycle, for half a second.
  const int whole = static_cast<int>(planned.plan->until(Step::home) / kPeriod);
  int slowest = 0;
  for (int at = 1; at < whole; at += 40) {
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
  std::printf("at rest after at most %d ms\n", slowest);
}

TEST(Path, KeepsTheLimitsWhateverEnableDoes) {
  std::mt19937 random{3};
  for (int n = 0; n < 40; ++n) {
    const Planned planned = plan(task(anywhere(random), anywhere(random)));
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

TEST(Path, DoesNotBeginWhileItIsHeld) {
  const Planned planned = plan(task(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2)));
  Path path{home()};
  for (int n = 0; n < 1000; ++n) path.advance(false, most(), kPeriod);
  path.begin(*planned.plan, Step::to_pick);
  for (int n = 0; n < 1000; ++n) path.advance(false, most(), kPeriod);
  EXPECT_EQ(path.position(), home());
  EXPECT_TRUE(path.busy());
}

TEST(Path, GoesHomeFromOverThePartWhenItGivesUp) {
  const Planned planned = plan(task(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2)));
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

TEST(Planner, RefusesWhatCannotBeDone) {
  const KDL::Frame good = down(0.75, 0.45, 0.3);
  for (const auto& [state, bad, why] :
       std::initializer_list<std::tuple<Planner::State, KDL::Frame, const char*>>{
           {Planner::State::out_of_reach, down(2, 0, 0.3), "too far"},
           {Planner::State::out_of_reach, down(0.8, 0, -1.5), "too low"},
           // The wrist at 1.2505 m of the 1.2512 m that the upper arm and the forearm are long together.
           {Planner::State::singular, down(0.16 + 1.2505, 0, 0.2), "stretched"}}) {
    const Planned pick = plan(task(bad, good));
    EXPECT_EQ(pick.state, state) << "pick " << why << " in " << pick.periods;
    const Planned place = plan(task(good, bad));
    EXPECT_EQ(place.state, state) << "place " << why << " in " << place.periods;
    std::printf("%s: refused after %d periods\n", why, place.periods);
  }
}

// Of all bodies: motion and height.
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

TEST(RigidArm, KeepsItsEnergyWhenItSwingsFreely) {
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
  std::printf("%.3g J of %.1f after %.2f rad\n", drift, kinetic_from, moved);
  EXPECT_GT(moved, 0.5);
  EXPECT_LT(drift, 1e-3);
}

TEST(RigidArm, StandsUnderTheTorqueThatCarriesItsWeight) {
  arm::RigidArm arm{figures()};
  servo::JointServo servo{figures()};
  const servo::Motion rest{arm.position, {}};
  const Joints weight = servo.torque(rest, rest, rest, kPeriod);
  EXPECT_GT(std::abs(weight[1]), 50);
  for (int n = 0; n < 200; ++n) arm.step(weight, kPeriod);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_NEAR(arm.position[i], home()[i], 1e-9);
  for (int n = 0; n < 200; ++n) arm.step({}, kPeriod);
  EXPECT_GT(arm.position[1], home()[1] + 0.01) << "without it, it falls forwards";
}

TEST(RigidArm, FrictionBringsItToRestAndTheBrakesSooner) {
  arm::RigidArm arm{figures()};
  arm.velocity = {2, 0, 0, 0, 0, 4};  // the axes that no weight turns at home: the first, and the tool's
  const Joints weight = servo::JointServo{figures()}.torque({arm.position, {}}, {arm.position, {}},
                                                            {arm.position, {}}, kPeriod);
  for (int n = 0; n < 5000; ++n) arm.step(weight, kPeriod);
  EXPECT_NEAR(arm.velocity[0], 0, 0.05);
  EXPECT_NEAR(arm.velocity[5], 0, 0.05);
  arm.velocity.fill(1);
  for (int n = 0; n < 70; ++n) arm.brake(kPeriod);
  EXPECT_EQ(arm.velocity, Joints{});
}

TEST(RigidArm, StopsAtTheLimitsOfItsAxes) {
  arm::RigidArm arm{figures()};
  for (int n = 0; n < 5000; ++n) arm.step({900, 1000, 600, 150, 150, 80}, kPeriod);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_LE(arm.position[i], figures()[i].upper);
  EXPECT_EQ(arm.position[0], figures()[0].upper);
}

TEST(RigidArm, RefusesFrictionThatCannotBeIntegrated) {
  EXPECT_EQ(arm::RigidArm::too_stiff(figures()), kAxes);
  arm_model::Parameters stiff = figures();
  stiff[3].dry = 200;
  EXPECT_EQ(arm::RigidArm::too_stiff(stiff), 3U);
}

TEST(JointServo, NeverAsksForMoreThanTheDrivesGive) {
  servo::JointServo servo{figures()};
  servo::Motion far{home(), {}};
  for (double& position : far.position) position += 3;
  const Joints torque = servo.torque(far, far, {home(), {}}, kPeriod);
  for (std::size_t i = 0; i < kAxes; ++i) EXPECT_LE(std::abs(torque[i]), figures()[i].torque);
  EXPECT_EQ(torque[1], figures()[1].torque);
}

// The three together, with the delay that they have as modules of one table: the measurement of the period
// before.
struct Followed {
  double axis = 0;     // rad, the farthest that one was off
  double tool = 0;     // m, on the whole path
  double at_part = 0;  // m, at the end of gripping and of releasing
  double torque = 0;   // share of what the drives give
};
Followed follow(const trajectory::Task& task, const std::function<void(servo::JointServo&)>& change = {},
                double load = 0) {
  const Planned planned = plan(task);
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
    path.advance(true, most(), kPeriod);
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

TEST(JointServo, FollowsAWholeCycleWithinMillimetres) {
  const Followed followed = follow(task(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2, 1)));
  std::printf("axes %.2g rad, tool %.2g m, at the parts %.2g m, torque %.2f of the drives'\n", followed.axis,
              followed.tool, followed.at_part, followed.torque);
  EXPECT_LT(followed.tool, 1e-4);
  EXPECT_LT(followed.at_part, 1e-6);
  EXPECT_LT(followed.torque, 1);
}

TEST(JointServo, FollowsWithinAMillimetreAtThePartsWithALoadThatNobodyToldItOf) {
  const Followed followed = follow(task(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2, 1)), {}, 5);
  std::printf("with 5 kg: tool %.2g m, at the parts %.2g m\n", followed.tool, followed.at_part);
  EXPECT_LT(followed.tool, 3e-3);
  EXPECT_LT(followed.at_part, 1e-3);
  EXPECT_GT(followed.at_part, 1e-5) << "the load is not there";
}

TEST(JointServo, HangsThroughWithoutTheWeightAndLagsWithoutTheAcceleration) {
  const auto way = task(down(0.75, 0.45, 0.3), down(0.5, -0.7, 0.2, 1));
  const Followed with = follow(way);
  const Followed without_gravity = follow(way, [](servo::JointServo& servo) { servo.gravity = false; });
  const Followed without_acceleration =
      follow(way, [](servo::JointServo& servo) { servo.acceleration = false; });
  EXPECT_GT(without_gravity.at_part, 2e-4);
  EXPECT_LT(with.at_part, 1e-6);
  EXPECT_GT(without_acceleration.tool, 20 * with.tool);
}

}  // namespace
