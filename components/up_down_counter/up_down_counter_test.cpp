#include "iec_counter.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace up_down_counter {
namespace {

using common::flag;

TEST(IecCounter, ReportsWhenItIsFullOrEmpty) {
  IecCounter counter;
  EXPECT_TRUE(counter.empty());
  for (int i = 0; i < 3; ++i) counter.step({.up = 1}, 3);
  EXPECT_TRUE(counter.full(3));
  counter.step({.down = 1}, 3);
  EXPECT_FALSE(counter.full(3));
  EXPECT_FALSE(counter.empty());
  counter.step({.up = 1, .down = 1}, 3);
  EXPECT_EQ(counter.value(), 2);
}

TEST(IecCounter, PrefersResetToLoadAndLoadToCounting) {
  IecCounter counter;
  counter.step({.up = 1, .load = true}, 7);
  EXPECT_EQ(counter.value(), 7);
  counter.step({.up = 1, .reset = true, .load = true}, 7);
  EXPECT_EQ(counter.value(), 0);
}

TEST(IecCounter, SaturatesAtTheLimitsOfItsRange) {
  constexpr std::int64_t kHighest = std::numeric_limits<std::int64_t>::max();
  constexpr std::int64_t kLowest = std::numeric_limits<std::int64_t>::min();
  IecCounter counter;
  counter.step({.load = true}, kHighest - 1);
  counter.step({.up = 5}, 0);
  EXPECT_EQ(counter.value(), kHighest);
  counter.step({.load = true}, kLowest + 1);
  counter.step({.down = 5}, 0);
  EXPECT_EQ(counter.value(), kLowest);
}

TEST(UpDownCounter, MatchesASimpleReferenceForRandomInputs) {
  takt::testing::Module module;
  auto& up = module.in<basic::Flag>("up", {.queue = 16});
  auto& down = module.in<basic::Flag>("down");
  auto& reset = module.in<basic::Flag>("reset");
  auto& load = module.in<basic::Flag>("load");
  auto& value = module.out<basic::Count>("value");
  auto& full = module.out<basic::Flag>("full");
  auto& empty = module.out<basic::Flag>("empty");
  ASSERT_TRUE(module.set("preset", "5"));
  ASSERT_TRUE(module.start());
  std::mt19937 random(15);
  std::int64_t expected = 0;
  bool up_last = false;
  bool down_last = false;
  for (int i = 0; i < 5000; ++i) {
    int ups = 0;
    for (auto n = random() % 6; n > 0; --n) {
      const bool now = random() % 2 == 0;
      ups += now && !up_last ? 1 : 0;
      up_last = now;
      up.write(flag(now));
    }
    const bool down_now = random() % 3 != 0;
    const int downs = down_now && !down_last ? 1 : 0;
    down_last = down_now;
    const bool reset_now = random() % 50 == 0;
    const bool load_now = random() % 50 == 0;
    down.write(flag(down_now));
    reset.write(flag(reset_now));
    load.write(flag(load_now));
    expected = reset_now ? 0 : load_now ? 5 : expected + ups - downs;
    module.step();
    ASSERT_EQ(value.value().value(), expected) << i;
    ASSERT_EQ(full.value().value(), expected >= 5);
    ASSERT_EQ(empty.value().value(), expected <= 0);
  }
}

TEST(UpDownCounter, KeepsItsValueAfterARecovery) {
  takt::testing::Module module;
  auto& up = module.in<basic::Flag>("up");
  auto& value = module.out<basic::Count>("value");
  ASSERT_TRUE(module.start());
  up.write(flag(true));
  module.step();
  ASSERT_TRUE(module.error(takt::ErrorType::budget));
  ASSERT_TRUE(module.recover());
  module.step();
  EXPECT_EQ(value.value().value(), 1);
}

TEST(UpDownCounter, KeepsItsValueAfterACrashUntilAReset) {
  takt::testing::Module module;
  auto& up = module.in<basic::Flag>("up");
  auto& value = module.out<basic::Count>("value");
  ASSERT_TRUE(module.start());
  for (const bool each : {true, false, true}) {
    up.write(flag(each));
    module.step();
  }
  ASSERT_TRUE(module.crash());
  ASSERT_TRUE(module.recover());
  up.write(flag(true));  // still true, so this is no edge
  module.step();
  EXPECT_EQ(value.value().value(), 2);
  ASSERT_TRUE(module.destruct());
  ASSERT_TRUE(module.reset());
  ASSERT_TRUE(module.start());
  up.write(flag(false));
  module.step();
  EXPECT_EQ(value.value().value(), 0);
}

TEST(UpDownCounter, AppliesANewPresetWhileItRuns) {
  takt::testing::Module module;
  auto& up = module.in<basic::Flag>("up");
  auto& full = module.out<basic::Flag>("full");
  ASSERT_TRUE(module.start());
  up.write(flag(true));
  module.step();
  EXPECT_FALSE(full.value().value());
  ASSERT_TRUE(module.set("preset", "1"));
  module.step();
  EXPECT_TRUE(full.value().value());
}

}  // namespace
}  // namespace up_down_counter
