#include "temperature_loop.h"

#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include <takt/testing.hpp>

namespace {

constexpr double kPeriod = 300e-6;

struct Plant {
  zone block = zone_at_room(20);
  heater_loop loop{.gain = 30, .integral_time = 4, .power_limit = 400, .integral = 0};
  double hottest = 0;

  void run(double seconds, double wanted) {
    for (double time = 0; time < seconds; time += kPeriod) {
      zone_step(&block, heater_loop_step(&loop, wanted, block.sensor, kPeriod), kPeriod);
      hottest = block.block > hottest ? block.block : hottest;
    }
  }
};

TEST(HeatingZone, StaysAtRoomTemperatureWithoutPower) {
  zone block = zone_at_room(20);
  for (int i = 0; i < 1000; ++i) zone_step(&block, 0, kPeriod);
  EXPECT_EQ(block.block, 20);
  EXPECT_EQ(block.sensor, 20);
}

TEST(HeaterLoop, BringsTheZoneToItsSetPoint) {
  Plant plant;
  plant.run(60, 80);
  EXPECT_NEAR(plant.block.sensor, 80, 0.1);
}

TEST(HeaterLoop, HardlyOvershootsAfterSaturation) {
  Plant plant;
  plant.run(60, 80);
  EXPECT_LT(plant.hottest, 83);
}

TEST(HeaterLoop, KeepsItsCommandBetweenZeroAndFullPower) {
  heater_loop loop{.gain = 30, .integral_time = 4, .power_limit = 400, .integral = 0};
  EXPECT_EQ(heater_loop_step(&loop, 20, 200, kPeriod), 0);
  EXPECT_EQ(heater_loop_step(&loop, 200, 20, kPeriod), 400);
}

TEST(HeaterLoop, HoldsItsIntegralWhileSaturated) {
  heater_loop loop{.gain = 30, .integral_time = 4, .power_limit = 400, .integral = 50};
  for (int i = 0; i < 100000; ++i) heater_loop_step(&loop, 200, 20, kPeriod);
  EXPECT_EQ(loop.integral, 50);
  for (int i = 0; i < 100000; ++i) heater_loop_step(&loop, 20, 200, kPeriod);
  EXPECT_EQ(loop.integral, 50);
}

using namespace std::chrono_literals;

TEST(Control4, HoldsTheZoneAtItsSetPoint) {
  takt::testing::Module module{{.period = 300us}};
  ASSERT_TRUE(module.set("high_c", "70"));
  ASSERT_TRUE(module.set("hold_s", "3600"));
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(200'000), 200'000U);  // 200,000 periods of 300 us are a minute
  testing::internal::CaptureStdout();
  ASSERT_TRUE(module.destruct());
  unsigned long long releases = 0;
  double is = 0, wanted = 0;
  ASSERT_EQ(std::sscanf(testing::internal::GetCapturedStdout().c_str(),
                        "control4: %llu releases, zone at %lf C, set point %lf C", &releases, &is, &wanted),
            3);
  EXPECT_EQ(releases, 200'000U);
  EXPECT_EQ(wanted, 70);
  EXPECT_NEAR(is, 70, 0.1);
}

TEST(Control4, RejectsASetPointBelowItsRange) {
  takt::testing::Module module;
  ASSERT_TRUE(module.set("low_c", "10"));
  const std::string problem = module.start().text();
  EXPECT_NE(problem.find("property 'low_c' cannot be '10'; it takes a number, 30 to 300, in degC"),
            std::string::npos)
      << problem;
}

}  // namespace
