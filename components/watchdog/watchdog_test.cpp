#include "life_sign.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include <takt/testing.hpp>

#include "../common/basic_values.hpp"

namespace watchdog {
namespace {

using common::count;
using common::flag;
using common::number;
using std::chrono::milliseconds;

TEST(LifeSign, IsNeitherAliveNorDeadBeforeTheFirstSign) {
  LifeSign life;
  for (int i = 0; i < 5; ++i) life.step(false, 10, 50);
  EXPECT_FALSE(life.alive());
  EXPECT_FALSE(life.dead());
  life.step(false, 10, 50);
  EXPECT_TRUE(life.dead());
}

TEST(LifeSign, IsDeadExactlyWhenTheLastSignIsOlderThanTheTimeout) {
  std::mt19937 random(12);
  LifeSign life;
  std::int64_t silent = 0;
  bool seen = false;
  for (int i = 0; i < 20000; ++i) {
    const bool sign = random() % 7 == 0;
    const auto passed = static_cast<std::int64_t>(random() % 3 + 1) * 10;
    silent = sign ? 0 : silent + passed;
    if (sign) seen = true;
    life.step(sign, passed, 100);
    ASSERT_EQ(life.dead(), silent > 100) << i;
    ASSERT_EQ(life.alive(), seen && silent <= 100) << i;
    if (silent > 100) seen = false;
  }
}

class Watchdog : public ::testing::Test {
 protected:
  takt::testing::Module module{{.period = milliseconds{10}}};
  takt::testing::Out<basic::Flag>& healthy = module.out<basic::Flag>("healthy");
  takt::testing::Out<basic::Flag>& alarm = module.out<basic::Flag>("alarm");
  void SetUp() override { ASSERT_TRUE(module.set("timeout", "0.1")); }
};

TEST_F(Watchdog, RaisesAnAlarmIfNoInputIsConnected) {
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_TRUE(alarm.value().value());
  EXPECT_FALSE(healthy.value().value());
}

TEST_F(Watchdog, IsHealthyWhileTheCounterChanges) {
  auto& input = module.in<basic::Count>("count");
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_FALSE(alarm.value().value());
  EXPECT_FALSE(healthy.value().value());
  for (int i = 0; i < 50; ++i) {
    input.write(count(i));
    module.step(5);
    ASSERT_TRUE(healthy.value().value());
    ASSERT_FALSE(alarm.value().value());
  }
  module.step(6);
  EXPECT_TRUE(healthy.value().value());  // still healthy after 100 ms without a sign
  module.step();
  EXPECT_TRUE(alarm.value().value());
  input.write(count(100));
  module.step();
  EXPECT_TRUE(healthy.value().value());
}

TEST_F(Watchdog, RaisesAnAlarmIfSamplesDoNotChange) {
  auto& input = module.in<basic::Count>("count");
  ASSERT_TRUE(module.start());
  for (int i = 0; i < 20; ++i) {
    input.write(count(7));
    module.step();
  }
  EXPECT_TRUE(alarm.value().value());
  ASSERT_TRUE(module.set("sign", "sample"));
  input.write(count(7));
  module.step();
  EXPECT_TRUE(healthy.value().value());
}

TEST_F(Watchdog, DoesNotTakeANonFiniteNumberAsASignOfLife) {
  auto& input = module.in<basic::Number>("number");
  ASSERT_TRUE(module.set("sign", "sample"));
  ASSERT_TRUE(module.start());
  input.write(number(1));
  module.step();
  EXPECT_TRUE(healthy.value().value());
  for (int i = 0; i < 20; ++i) {
    input.write(number(std::nan("")));
    module.step();
  }
  EXPECT_TRUE(alarm.value().value());
}

TEST_F(Watchdog, MonitorsEachInputSeparately) {
  auto& a = module.in<basic::Count>("count");
  auto& b = module.in<basic::Flag>("flag");
  ASSERT_TRUE(module.start());
  for (int i = 0; i < 30; ++i) {
    a.write(count(i));
    if (i < 15) b.write(flag(i % 2 == 0));
    module.step();
    ASSERT_EQ(healthy.value().value(), i <= 24) << i;
  }
}

TEST_F(Watchdog, CountsTheTimeOfMissedReleases) {
  auto& input = module.in<basic::Count>("count");
  ASSERT_TRUE(module.start());
  input.write(count(1));
  module.step();
  module.miss(10);
  module.step();
  EXPECT_TRUE(alarm.value().value());
}

TEST_F(Watchdog, KeepsALatchedAlarmUntilTheReset) {
  auto& input = module.in<basic::Count>("count");
  auto& reset = module.in<basic::Flag>("reset");
  ASSERT_TRUE(module.set("latching", "true"));
  ASSERT_TRUE(module.start());
  module.step(20);
  input.write(count(1));
  module.step();
  EXPECT_TRUE(alarm.value().value());
  reset.write(flag(true));
  module.step();
  EXPECT_FALSE(alarm.value().value());
  EXPECT_TRUE(healthy.value().value());
}

TEST_F(Watchdog, RejectsATimeoutShorterThanItsPeriod) {
  ASSERT_TRUE(module.set("timeout", "0.005"));
  const auto start = module.start();
  ASSERT_FALSE(start.ok());
  EXPECT_NE(start.text().find("0.01 to 1e+06 at a period of 10 ms"), std::string::npos) << start.text();
}

}  // namespace
}  // namespace watchdog
