#include "belt.hpp"

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

TEST(Belt, IsNotReleasedByTheNumberOfAPartThatIsGone) {
  Belt belt;
  while (!belt.step(0.5, kPeriod)) {
  }
  belt.taken(1);
  while (!belt.step(0.5, kPeriod)) {
  }
  belt.taken(1);
  EXPECT_TRUE(belt.holding);
}

TEST(Belt, StopsWhenItIsToldTo) {
  Belt belt;
  for (int i = 0; i < 200; ++i) belt.step(0.5, kPeriod);
  EXPECT_GT(belt.speed, 0.3);
  for (int i = 0; i < 500; ++i) belt.step(0, kPeriod);
  EXPECT_NEAR(belt.speed, 0, 1e-12);
}

TEST(Belt, NeverAcceleratesMoreThanItMay) {
  Belt belt{.acceleration = 0.5};
  double last = 0;
  for (int i = 0; i < 300; ++i) {
    belt.step(2, kPeriod);
    if (belt.holding) break;
    EXPECT_LE(belt.speed - last, 0.5 * kPeriod + 1e-12);
    last = belt.speed;
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

TEST(Conveyor, TellsOfEachPartAndGoesOnWhenItWasTaken) {
  takt::testing::Module module{{.period = 2ms}};
  ASSERT_TRUE(module.set("spacing", "0.5"));
  auto& command = module.in<line::BeltCommand>("command");
  auto& taken = module.in<motion::PickDone>("taken", {.queue = 8});
  auto& part = module.out<line::PartSeen>("part");
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

TEST(Conveyor, SaysAPartThatWaitsAgainAndAgain) {
  takt::testing::Module module{{.period = 2ms}};
  ASSERT_TRUE(module.set("repeat", "0.1"));
  auto& command = module.in<line::BeltCommand>("command");
  auto& part = module.out<line::PartSeen>("part");
  ASSERT_TRUE(module.start());
  command.write(speed(0.5));
  ASSERT_TRUE(module.step_until([&] { return part.count() == 1; }, 1000));
  module.step(200);  // 0.4 s
  EXPECT_EQ(part.count(), 5U);
  EXPECT_EQ(part.value().number(), 1U);
}

TEST(Conveyor, StandsStillWhenItsCommandIsStale) {
  takt::testing::Module module{{.period = 2ms}};
  auto& command = module.in<line::BeltCommand>("command", {.deadline = 100ms, .stale_is_error = true});
  auto& state = module.out<line::BeltState>("state");
  ASSERT_TRUE(module.start());
  command.write(speed(0.1));
  module.step(51);  // to 100 ms after the first
  EXPECT_GT(state.value().speed(), 0.09);
  module.step();
  EXPECT_EQ(module.state(), State::recover);
  EXPECT_EQ(module.last_error().type, takt::ErrorType::stale);

  ASSERT_TRUE(module.recover());
  command.write(speed(0.1));
  module.step();
  EXPECT_LT(state.value().speed(), 0.003);  // from standstill
}

TEST(Conveyor, GoesOnCountingFromANumber) {
  takt::testing::Module module{{.period = 2ms}};
  auto& command = module.in<line::BeltCommand>("command");
  auto& part = module.out<line::PartSeen>("part");
  auto& taken = module.in<motion::PickDone>("taken", {.queue = 8});
  auto& request = module.in<takt::ServiceRequest<basic::Count>>("count/request");
  auto& reply = module.out<takt::ServiceReply<basic::Count>>("count/reply");
  ASSERT_TRUE(module.start());
  command.write(speed(0.5));
  ASSERT_TRUE(module.step_until([&] { return part.count() == 1; }, 1000));

  takt::ServiceRequest<basic::Count> recount{.client = 1, .number = 1, .timeout_ns = 1'000'000'000};
  recount.request.value(41);
  request.write(recount);
  module.step();
  EXPECT_EQ(reply.value().code, takt::ServiceCode::refused) << "the part at the barrier has its number";
  taken.write(done(1));
  module.step();
  recount.number = 2;
  request.write(recount);
  module.step();
  EXPECT_EQ(reply.value().code, takt::ServiceCode::replied) << reply.value().reason.data();
  EXPECT_EQ(reply.value().number, 2U);
  EXPECT_EQ(reply.value().reply.value(), 1);
  ASSERT_TRUE(module.step_until([&] { return part.count() == 2; }, 1000));
  EXPECT_EQ(part.value().number(), 42U);

  taken.write(done(42));
  module.step();
  recount.request.value(-1);
  request.write(recount);
  module.step();
  EXPECT_STREQ(reply.value().reason.data(), "a count is 0 to 1000000000");
}

TEST(Conveyor, RefusesWhatNoBeltCanDo) {
  takt::testing::Module module;
  EXPECT_EQ(module.set("spacing", "0").text(),
            "property 'spacing' cannot be '0'; it takes a number, 0.05 to 10, in m");
  EXPECT_FALSE(module.set("acceleration", "fast"));
}

}  // namespace
}  // namespace conveyor
