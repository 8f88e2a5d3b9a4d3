#include <components/control4/temperature_loop.h>

#include <gtest/gtest.h>

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

TEST(Zone, StaysAtRoomTemperatureWithoutPower) {
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

TEST(HeaterLoop, OvershootsLittleAfterTheHeaterWasAtItsBound) {
  Plant plant;
  plant.run(60, 80);
  EXPECT_LT(plant.hottest, 83);
}

TEST(HeaterLoop, NeitherCoolsNorExceedsItsPower) {
  heater_loop loop{.gain = 30, .integral_time = 4, .power_limit = 400, .integral = 0};
  EXPECT_EQ(heater_loop_step(&loop, 20, 200, kPeriod), 0);
  EXPECT_EQ(heater_loop_step(&loop, 200, 20, kPeriod), 400);
}

TEST(HeaterLoop, HoldsItsIntegralWhileBounded) {
  heater_loop loop{.gain = 30, .integral_time = 4, .power_limit = 400, .integral = 50};
  for (int i = 0; i < 100000; ++i) heater_loop_step(&loop, 200, 20, kPeriod);
  EXPECT_EQ(loop.integral, 50);
  for (int i = 0; i < 100000; ++i) heater_loop_step(&loop, 20, 200, kPeriod);
  EXPECT_EQ(loop.integral, 50);
}

}  // namespace
