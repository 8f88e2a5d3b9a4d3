#include "belt.hpp"

#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <basic.hpp>
#include <line.hpp>
#include <motion.hpp>

namespace conveyor {
namespace {

constexpr double kPeriod = 2e-3;

TEST(Belt, HoldsEachPartUntilItIsTaken) {
  Belt belt;
  int seen = 0;
  for (int i = 0; i < 5000; ++i) seen += belt.step(0.5, kPeriod) ? 1 : 0;
  EXPECT_EQ(seen, 1);
  EXPECT_TRUE(belt.holding);
  EXPECT_EQ(belt.speed, 0);

  belt.taken(1);
  for (int i = 0; i < 5000; ++i) seen += belt.step(0.5, kPeriod) ? 1 : 0;
  EXPECT_EQ(seen, 2);
  EXPECT_EQ(belt.parts, 2U);
}

TEST(Belt, IgnoresARepeatedRemovalOfTheSamePart) {
  Belt belt;
  while (!belt.step(0.5, kPeriod)) {
  }
  belt.taken(1);
  while (!belt.step(0.5, kPeriod)) {
  }
  belt.taken(1);
  EXPECT_TRUE(belt.holding);
}

TEST(Belt, BrakesToAStandstillAtSpeedZero) {
  Belt belt;
  for (int i = 0; i < 200; ++i) belt.step(0.5, kPeriod);
  EXPECT_GT(belt.speed, 0.3);
  for (int i = 0; i < 500; ++i) belt.step(0, kPeriod);
  EXPECT_NEAR(belt.speed, 0, 1e-12);
}

TEST(Belt, NeverExceedsItsAcceleration) {
  Belt belt{.acceleration = 0.5};
  double last = 0;
  for (int i = 0; i < 300; ++i) {
    belt.step(2, kPeriod);
    if (belt.holding) break;
    EXPECT_LE(belt.speed - last, 0.5 * kPeriod + 1e-12);
    last = belt.speed;
  }
}

TEST(Belt, StandsStillAtANegativeOrNonFiniteSpeed) {
  Belt belt;
  for (const double wanted :
       {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (int i = 0; i < 500; ++i) belt.step(wanted, kPeriod);
  EXPECT_EQ(belt.position, 0);
}

TEST(Belt, BringsTheSamePartsInEachRun) {
  Belt slow{.acceleration = 0.1};
  Belt fast{.acceleration = 5};
  while (!slow.step(0.1, kPeriod)) {
  }
  while (!fast.step(1, kPeriod)) {
  }
  for (std::uint32_t number = 1; number < 50; ++number) {
    EXPECT_EQ(slow.laid(number).y, fast.laid(number).y);
    EXPECT_EQ(slow.laid(number).angle, fast.laid(number).angle);
    EXPECT_STREQ(slow.laid(number).kind, fast.laid(number).kind);
    EXPECT_NE(slow.laid(number).y, slow.laid(number + 1).y);
    EXPECT_LE(std::abs(slow.laid(number).y), 0.05);
    EXPECT_LE(std::abs(slow.laid(number).angle), std::numbers::pi / 4);
  }
}

TEST(Belt, ReportsThePositionOfTheNextPart) {
  Belt belt;
  EXPECT_EQ(belt.first(), 1U);
  EXPECT_DOUBLE_EQ(belt.laid(1).x, 0.3);
  while (!belt.step(0.5, kPeriod)) {
  }
  EXPECT_EQ(belt.first(), 1U);
  EXPECT_NEAR(belt.laid(1).x, 0, 0.5 * kPeriod);  // at most one step past the barrier
  EXPECT_LE(belt.laid(1).x, 0);
  belt.taken(1);
  EXPECT_EQ(belt.first(), 2U);
  EXPECT_NEAR(belt.laid(2).x, 0.3, 0.5 * kPeriod);
}

// Checks the formula of README.md, with a tolerance of two periods per part.
TEST(Belt, BringsAsManyPartsPerMinuteAsTheFormulaPredicts) {
  struct Case {
    double spacing, speed, acceleration, held;
  };
  for (const Case c :
       {Case{0.3, 0.4, 1, 1.2}, Case{0.3, 0.3, 1, 0}, Case{0.1, 2, 1, 0.5}, Case{1, 0.2, 5, 3}}) {
    Belt belt{.acceleration = c.acceleration, .spacing = c.spacing};
    double held = 0;
    const int steps = static_cast<int>(600 / kPeriod);
    for (int i = 0; i < steps; ++i) {
      if (belt.holding && (held += kPeriod) >= c.held) {
        belt.taken(belt.parts);
        held = 0;
      }
      belt.step(c.speed, kPeriod);
    }
    const double between = time_between(c.spacing, c.speed, c.acceleration) + c.held;
    EXPECT_LE(belt.parts, 600 / (between - 2 * kPeriod) + 1);
    EXPECT_GE(belt.parts, 600 / (between + 2 * kPeriod) - 1);
  }
}

using namespace std::chrono_literals;
using takt::lifecycle::State;

line::BeltCommand speed(double value) {
  line::BeltCommand command;
  command.speed(value);
  return command;
}

motion::PickDone done(std::uint32_t number) {
  motion::PickDone part;
  part.number(number);
  return part;
}

TEST(Conveyor, BringsTheNextPartWhenTheWaitingPartIsTaken) {
  takt::testing::Module module{{.period = 2ms}};
  ASSERT_TRUE(module.set("spacing", "0.5"));
  auto& command = module.in<line::BeltCommand>("command");
  auto& taken = module.in<motion::PickDone>("taken", {.queue = 8});
  auto& part = module.out<line::Part>("part");
  auto& state = module.out<line::BeltState>("state");
  ASSERT_TRUE(module.start());

  command.write(speed(0.5));
  ASSERT_TRUE(module.step_until([&] { return part.count() == 1; }, 1000));
  EXPECT_EQ(part.value().kind(), "bottle");
  module.step();
  EXPECT_EQ(state.value().mode(), line::BELT_HOLDING);

  taken.write(done(1));
  ASSERT_TRUE(module.step_until([&] { return part.count() == 2; }, 1000));
  EXPECT_EQ(part.value().number(), 2U);
  EXPECT_NEAR(state.value().position(), 1, 0.01);
}

TEST(Conveyor, RepeatsTheAnnouncementOfAWaitingPart) {
  takt::testing::Module module{{.period = 2ms}};
  ASSERT_TRUE(module.set("repeat", "0.1"));
  auto& command = module.in<line::BeltCommand>("command");
  auto& part = module.out<line::Part>("part");
  ASSERT_TRUE(module.start());
  command.write(speed(0.5));
  ASSERT_TRUE(module.step_until([&] { return part.count() == 1; }, 1000));
  module.step(200);  // 0.4 s of virtual time
  EXPECT_EQ(part.count(), 5U);
  EXPECT_EQ(part.value().number(), 1U);
}

TEST(Conveyor, GoesToRecoverAndStopsWhenItsCommandIsStale) {
  takt::testing::Module module{{.period = 2ms}};
  auto& command = module.in<line::BeltCommand>("command", {.deadline = 100ms, .stale_is_error = true});
  auto& state = module.out<line::BeltState>("state");
  ASSERT_TRUE(module.start());
  command.write(speed(0.1));
  module.step(51);  // the first command is then 100 ms old
  EXPECT_GT(state.value().speed(), 0.09);
  module.step();
  EXPECT_EQ(module.state(), State::recover);
  EXPECT_EQ(module.last_error().type, takt::ErrorType::stale);

  ASSERT_TRUE(module.recover());
  command.write(speed(0.1));
  module.step();
  EXPECT_LT(state.value().speed(), 0.003);  // the belt has just started from standstill
}

basic::Flag flag(bool value) {
  basic::Flag one;
  one.value(value);
  return one;
}

TEST(Conveyor, StandsStillWhileDisabled) {
  takt::testing::Module module{{.period = 2ms}};
  ASSERT_TRUE(module.set("spacing", "10"));
  auto& command = module.in<line::BeltCommand>("command");
  auto& enable = module.in<basic::Flag>("enable");
  auto& state = module.out<line::BeltState>("state");
  ASSERT_TRUE(module.start());
  command.write(speed(0.5));
  module.step(300);  // `enable` has no value during this time
  EXPECT_DOUBLE_EQ(state.value().speed(), 0.5);

  enable.write(flag(false));
  module.step(125);  // half of the braking time at 1 m/s^2
  EXPECT_NEAR(state.value().speed(), 0.25, 1e-9);
  module.step(126);
  EXPECT_EQ(state.value().mode(), line::BELT_STOPPED);
  const double stood = state.value().position();
  module.step(100);
  EXPECT_EQ(state.value().position(), stood);

  enable.write(flag(true));
  module.step(300);
  EXPECT_DOUBLE_EQ(state.value().speed(), 0.5);
}

TEST(Conveyor, WritesThePartsUpToTheBarrierToItsSceneOutput) {
  takt::testing::Module module{{.period = 2ms}};
  ASSERT_TRUE(module.set("view", "0.7"));
  auto& command = module.in<line::BeltCommand>("command");
  auto& taken = module.in<motion::PickDone>("taken", {.queue = 8});
  auto& scene = module.out<line::Scene>("scene");
  auto& barrier = module.out<basic::Flag>("barrier");
  auto& part = module.out<line::Part>("part");
  ASSERT_TRUE(module.start());
  module.step();
  ASSERT_EQ(scene.value().parts().size(), 2U);  // the parts at 0.3 and 0.6 m
  EXPECT_DOUBLE_EQ(scene.value().parts()[1].x(), 0.6);
  EXPECT_FALSE(barrier.value().value());

  command.write(speed(0.5));
  ASSERT_TRUE(module.step_until([&] { return barrier.value().value(); }, 1000));
  EXPECT_EQ(part.count(), 1U);
  ASSERT_EQ(scene.value().parts().size(), 3U);
  EXPECT_EQ(scene.value().parts()[0].number(), 1U);
  EXPECT_NEAR(scene.value().parts()[0].x(), 0, 1e-3);
  EXPECT_EQ(scene.value().parts()[0].y(), part.value().y());
  EXPECT_EQ(scene.value().parts()[0].kind(), part.value().kind());

  taken.write(done(1));
  module.step();
  EXPECT_FALSE(barrier.value().value());
  EXPECT_EQ(scene.value().parts()[0].number(), 2U);
}

TEST(Conveyor, WritesAtMostSixteenPartsToItsSceneOutput) {
  takt::testing::Module module{{.period = 2ms}};
  ASSERT_TRUE(module.set("view", "10"));
  ASSERT_TRUE(module.set("spacing", "0.05"));
  auto& scene = module.out<line::Scene>("scene");
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_EQ(scene.value().parts().size(), 16U);
  EXPECT_EQ(scene.unfit(), 0U);
}

TEST(Conveyor, ContinuesCountingFromARequestedNumber) {
  takt::testing::Module module{{.period = 2ms}};
  auto& command = module.in<line::BeltCommand>("command");
  auto& part = module.out<line::Part>("part");
  auto& taken = module.in<motion::PickDone>("taken", {.queue = 8});
  ASSERT_TRUE(module.start());
  command.write(speed(0.5));
  ASSERT_TRUE(module.step_until([&] { return part.count() == 1; }, 1000));

  const auto recount = [&module](std::int64_t from) {
    basic::Count number;
    number.value(from);
    return module.call<basic::Count, basic::Count>("count", number);
  };
  EXPECT_FALSE(recount(41)) << "the number of the waiting part must not change";
  taken.write(done(1));
  module.step();
  const auto last = recount(41);
  ASSERT_TRUE(last);
  EXPECT_EQ(last->value(), 1);
  ASSERT_TRUE(module.step_until([&] { return part.count() == 2; }, 1000));
  EXPECT_EQ(part.value().number(), 42U);

  taken.write(done(42));
  module.step();
  EXPECT_EQ(recount(-1).text(), "the count must be 0 to 1000000000");
}

TEST(Conveyor, RejectsPropertiesOutOfRange) {
  takt::testing::Module module;
  EXPECT_EQ(module.set("spacing", "0").text(),
            "property 'spacing' cannot be '0'; it takes a number, 0.05 to 10, in m");
  EXPECT_FALSE(module.set("acceleration", "fast"));
}

TEST(Conveyor, StopsWhenItsEnableInputTimesOut) {
  takt::testing::Module module{{.period = 2ms}};
  ASSERT_TRUE(module.set("enable_timeout", "0.1"));
  auto& command = module.in<line::BeltCommand>("command");
  auto& enable = module.in<basic::Flag>("enable");
  auto& state = module.out<line::BeltState>("state");
  ASSERT_TRUE(module.start());
  line::BeltCommand fast;
  fast.speed(0.5);
  command.write(fast);
  module.step(100);
  EXPECT_EQ(state.value().speed(), 0) << "the belt moved although enable has no value";
  basic::Flag yes;
  yes.value(true);
  for (int i = 0; i < 100; ++i) {
    enable.write(yes);
    module.step();
  }
  EXPECT_GT(state.value().speed(), 0.1);
  module.step(400);  // the belt brakes after 0.1 s without a value
  EXPECT_EQ(state.value().speed(), 0);
}

TEST(Conveyor, KeepsHoldingAPartThatTheRobotRejected) {
  takt::testing::Module module{{.period = 2ms}};
  auto& command = module.in<line::BeltCommand>("command");
  auto& taken = module.in<motion::PickDone>("taken", {.queue = 8});
  auto& state = module.out<line::BeltState>("state");
  ASSERT_TRUE(module.start());
  line::BeltCommand fast;
  fast.speed(0.5);
  command.write(fast);
  module.step(1000);
  ASSERT_EQ(state.value().mode(), line::BELT_HOLDING);
  motion::PickDone done;
  done.number(1);
  done.result(motion::PICK_REFUSED);
  taken.write(done);
  module.step(2);
  EXPECT_EQ(state.value().mode(), line::BELT_HOLDING);
  done.result(motion::PICK_PLACED);
  taken.write(done);
  module.step(2);
  EXPECT_EQ(state.value().mode(), line::BELT_RUNNING);
}

}  // namespace
}  // namespace conveyor
