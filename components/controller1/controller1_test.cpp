#include "position_loop.hpp"

#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include <takt/testing.hpp>

namespace controller1 {
namespace {

constexpr double kPeriod = 600e-6;

TEST(Move, BeginsAndEndsAtStandstill) {
  const Move move{.from = 10, .to = -90, .velocity = 500, .acceleration = 5000};
  EXPECT_EQ(move.at(-1).position, 10);
  EXPECT_EQ(move.at(0).velocity, 0);
  EXPECT_EQ(move.at(move.duration()).position, -90);
  EXPECT_EQ(move.at(move.duration() + 1).velocity, 0);
}

TEST(Move, NeverExceedsItsVelocityAndAcceleration) {
  const Move move{.from = 0, .to = 100, .velocity = 500, .acceleration = 5000};
  const double dt = 1e-4;
  for (double time = 0; time < move.duration(); time += dt) {
    EXPECT_LE(std::abs(move.at(time).velocity), 500 + 1e-9);
    EXPECT_LE(std::abs(move.at(time + dt).velocity - move.at(time).velocity) / dt, 5000 + 1e-3);
    EXPECT_NEAR((move.at(time + dt).position - move.at(time).position) / dt, move.at(time + dt / 2).velocity,
                0.2);
  }
}

TEST(Move, HasATriangularProfileWhenTooShortToReachItsVelocity) {
  const Move move{.from = 0, .to = 1, .velocity = 500, .acceleration = 5000};
  EXPECT_NEAR(move.duration(), 2 * std::sqrt(1.0 / 5000), 1e-9);
  EXPECT_NEAR(move.at(move.duration() / 2).position, 0.5, 1e-9);
}

TEST(Move, TakesNoTimeWhenItsDistanceIsZero) {
  const Move move{.from = 5, .to = 5, .velocity = 500, .acceleration = 5000};
  EXPECT_EQ(move.duration(), 0);
  EXPECT_EQ(move.at(0).position, 5);
}

TEST(PositionLoop, BringsTheAxisToANewSetPoint) {
  Axis axis;
  PositionLoop loop;
  for (int i = 0; i < 5000; ++i) axis.step(loop.step({10, 0}, axis.position, kPeriod), kPeriod);
  EXPECT_NEAR(axis.position, 10, 1e-6);
}

TEST(PositionLoop, DoesNotWindUpWhileItsCommandIsLimited) {
  Axis axis;
  PositionLoop loop{.command_limit = 50};
  // During the step of 100 mm, the command stays at its limit, 50 mm/s, for two seconds.
  double highest = 0;
  for (int i = 0; i < 10000; ++i) {
    axis.step(loop.step({100, 0}, axis.position, kPeriod), kPeriod);
    highest = std::max(highest, axis.position);
  }
  EXPECT_NEAR(axis.position, 100, 1e-3);
  EXPECT_LT(highest, 101);
}

TEST(InPosition, NeedsConsecutiveSamplesInsideTheWindow) {
  InPosition in_position{.window = 0.01, .counter = 3};
  EXPECT_FALSE(in_position.step(0.005));
  EXPECT_FALSE(in_position.step(-0.01));
  EXPECT_FALSE(in_position.step(0.011));
  EXPECT_FALSE(in_position.step(0));
  EXPECT_FALSE(in_position.step(0));
  EXPECT_TRUE(in_position.step(0));
}

TEST(InPosition, NeedsOneSampleInsideTheWindowIfTheCounterIsOne) {
  InPosition in_position{.window = 0.01, .counter = 1};
  EXPECT_FALSE(in_position.step(0.02));
  EXPECT_TRUE(in_position.step(0.01));
}

TEST(Shuttle, MovesBackAndForthWithASmallFollowingError) {
  Shuttle shuttle;
  shuttle.move.velocity = 500;
  shuttle.move.acceleration = 5000;
  shuttle.begin();
  for (int i = 0; i < 20000; ++i) shuttle.step(kPeriod);  // 12 s of virtual time
  EXPECT_GT(shuttle.moves, 15u);
  EXPECT_LT(shuttle.moves, 25u);
  EXPECT_LT(shuttle.largest_error, 2);
  EXPECT_LT(shuttle.settling, 0.4);
}

TEST(Shuttle, SettlesLaterByEachPeriodAddedToItsCounter) {
  double settling[2] = {};
  for (int which = 0; which < 2; ++which) {
    Shuttle shuttle;
    shuttle.move.velocity = 500;
    shuttle.move.acceleration = 5000;
    shuttle.in_position.counter = which == 0 ? 5 : 105;
    shuttle.begin();
    for (int i = 0; i < 5000; ++i) shuttle.step(kPeriod);
    settling[which] = shuttle.settling;
  }
  EXPECT_NEAR(settling[1] - settling[0], 100 * kPeriod, 1e-9);
}

using namespace std::chrono_literals;

std::string end_of(takt::testing::Module& module) {
  testing::internal::CaptureStderr();
  EXPECT_TRUE(module.destruct());
  return testing::internal::GetCapturedStderr();
}

TEST(Controller1, MovesBackAndForthWithThePeriodFromItsDescriptor) {
  takt::testing::Module module{{.period = 600us}};
  ASSERT_TRUE(module.set("stroke_mm", "200"));
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(10'000), 10'000U);  // 6 s of virtual time
  unsigned long long moves = 0;
  double stroke = 0, error = 0;
  ASSERT_EQ(
      std::sscanf(end_of(module).c_str(), "controller1: %llu moves of %lf mm, following error at most %lf mm",
                  &moves, &stroke, &error),
      3);
  EXPECT_NEAR(static_cast<double>(moves), 6 / 0.75, 2);  // a move and its rest take about 0.75 s
  EXPECT_EQ(stroke, 200);
  EXPECT_LT(error, 5);
}

TEST(Controller1, RestartsAtItsOriginAfterAnError) {
  takt::testing::Module module{{.period = 600us}};
  ASSERT_TRUE(module.start());
  module.step(100);
  ASSERT_TRUE(module.error(takt::ErrorType::overrun));
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.step(100), 100U);
  EXPECT_NE(end_of(module).find("1 errors"), std::string::npos);
}

TEST(Controller1, RejectsACounterOfZero) {
  takt::testing::Module module;
  ASSERT_TRUE(module.set("counter", "0"));
  EXPECT_EQ(module.start().text(),
            "property 'counter' cannot be '0'; it takes a whole number, 1 to 1000000, in periods");
}

}  // namespace
}  // namespace controller1
