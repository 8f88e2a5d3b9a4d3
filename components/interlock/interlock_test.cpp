#include "permissives.hpp"

#include <gtest/gtest.h>

#include <random>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace interlock {
namespace {

using common::flag;
using std::chrono::milliseconds;

TEST(Permissives, PermitWhenAllUsedInputsAreTrue) {
  Permissives permissives;
  for (std::uint32_t used = 0; used < 256; ++used) {
    for (std::uint32_t given = 0; given < 256; ++given) {
      ASSERT_EQ(permissives.step(used, given, false, false), used != 0 && (used & given) == used);
    }
  }
}

TEST(Permissives, KeepTheNumberOfTheFirstInputThatDropped) {
  Permissives permissives;
  permissives.step(0b111, 0b111, false, false);
  EXPECT_EQ(permissives.first_out(), 0);
  permissives.step(0b111, 0b101, false, false);
  EXPECT_EQ(permissives.first_out(), 2);
  permissives.step(0b111, 0b000, false, false);
  permissives.step(0b111, 0b010, false, false);
  EXPECT_EQ(permissives.first_out(), 2);
  permissives.step(0b111, 0b111, false, false);
  EXPECT_EQ(permissives.first_out(), 2);  // the number stays after all inputs are true again
  permissives.step(0b111, 0b011, false, false);
  EXPECT_EQ(permissives.first_out(), 3);  // the next input that drops replaces the number
}

TEST(Permissives, ReportTheLowestNumberIfSeveralInputsDropTogether) {
  Permissives permissives;
  permissives.step(0b1111, 0b1111, false, false);
  permissives.step(0b1111, 0b0001, false, false);
  EXPECT_EQ(permissives.first_out(), 2);
}

TEST(Permissives, ClearFirstOutOnlyIfAllInputsAreTrueAtTheReset) {
  Permissives permissives;
  permissives.step(1, 1, false, false);
  permissives.step(1, 0, false, true);
  EXPECT_EQ(permissives.first_out(), 1);
  permissives.step(1, 1, false, true);
  EXPECT_EQ(permissives.first_out(), 0);
}

TEST(Permissives, MatchASimpleReferenceForRandomInputs) {
  std::mt19937 random(17);
  for (const bool latching : {false, true}) {
    Permissives permissives;
    bool permitted = false;
    bool tripped = false;
    int first = 0;
    for (int i = 0; i < 20000; ++i) {
      std::uint32_t given = 0xff;
      if (random() % 3 == 0) given &= ~(1U << random() % 8);
      if (random() % 5 == 0) given &= ~(1U << random() % 8);
      const bool reset = random() % 4 == 0;
      const bool all = given == 0xff;
      if (permitted && !all) {
        for (first = 1; (given >> (first - 1) & 1) != 0;) ++first;
        tripped = latching;
      }
      if (all && reset) {
        first = 0;
        tripped = false;
      }
      permitted = all && !tripped;
      ASSERT_EQ(permissives.step(0xff, given, latching, reset), permitted) << i;
      ASSERT_EQ(permissives.first_out(), first) << i;
    }
  }
}

class Interlock : public ::testing::Test {
 protected:
  takt::testing::Module module{{.period = milliseconds{10}}};
  takt::testing::In<basic::Flag>& second = module.in<basic::Flag>("in_2");
  takt::testing::In<basic::Flag>& fifth = module.in<basic::Flag>("in_5");
  takt::testing::Out<basic::Flag>& permitted = module.out<basic::Flag>("permitted");
  takt::testing::Out<basic::Count>& first_out = module.out<basic::Count>("first_out");
  void cycle(bool a, bool b) {
    second.write(flag(a));
    fifth.write(flag(b));
    module.step();
  }
};

TEST_F(Interlock, PermitsOnlyWhenEachConnectedInputIsTrue) {
  ASSERT_TRUE(module.start());
  second.write(flag(true));
  module.step();
  EXPECT_FALSE(permitted.value().value());
  EXPECT_EQ(first_out.value().value(), 0);
  fifth.write(flag(true));
  module.step();
  EXPECT_TRUE(permitted.value().value());
}

TEST_F(Interlock, ReportsWhichInputDroppedFirst) {
  ASSERT_TRUE(module.start());
  cycle(true, true);
  cycle(true, false);
  EXPECT_FALSE(permitted.value().value());
  EXPECT_EQ(first_out.value().value(), 5);
  cycle(false, false);
  EXPECT_EQ(first_out.value().value(), 5);
}

TEST_F(Interlock, NeedsAResetToPermitAgainIfLatching) {
  auto& reset = module.in<basic::Flag>("reset");
  ASSERT_TRUE(module.set("latching", "true"));
  ASSERT_TRUE(module.start());
  cycle(true, true);
  EXPECT_TRUE(permitted.value().value());  // permitted, because no input has dropped yet
  cycle(false, true);
  cycle(true, true);
  EXPECT_FALSE(permitted.value().value());
  reset.write(flag(true));
  module.step();
  EXPECT_TRUE(permitted.value().value());
  EXPECT_EQ(first_out.value().value(), 0);
}

TEST_F(Interlock, TreatsAnExpiredInputAsFalse) {
  ASSERT_TRUE(module.set("timeout", "0.05"));
  ASSERT_TRUE(module.start());
  cycle(true, true);
  for (int i = 0; i < 5; ++i) {
    second.write(flag(true));
    module.step();
    EXPECT_TRUE(permitted.value().value());
  }
  second.write(flag(true));
  module.step();
  EXPECT_FALSE(permitted.value().value());
  EXPECT_EQ(first_out.value().value(), 5);
}

TEST_F(Interlock, PermitsNothingAfterAnError) {
  ASSERT_TRUE(module.start());
  cycle(true, true);
  ASSERT_TRUE(module.error(takt::ErrorType::stale));
  EXPECT_FALSE(permitted.value().value());
}

TEST(UnconnectedInterlock, DoesNotStartWithoutAPermissive) {
  takt::testing::Module module;
  const auto start = module.start();
  ASSERT_FALSE(start.ok());
  EXPECT_EQ(start.text(),
            "no permissive is connected, so the module can never permit anything; connect a flag to one of "
            "in_1 to in_8");
}

}  // namespace
}  // namespace interlock
