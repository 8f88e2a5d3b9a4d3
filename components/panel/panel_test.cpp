#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <line.hpp>

namespace {

using namespace std::chrono_literals;

TEST(Panel, WritesTheBeltSpeedEveryPeriod) {
  takt::testing::Module module{{.period = 100ms}};
  ASSERT_TRUE(module.set("speed", "0.7"));
  auto& command = module.out<line::BeltCommand>("command");
  auto& belt = module.in<line::BeltState>("belt");
  ASSERT_TRUE(module.start());
  EXPECT_EQ(command.count(), 0U);
  belt.write({});
  EXPECT_EQ(module.step(10), 10U);
  EXPECT_EQ(command.count(), 10U);
  EXPECT_EQ(command.value().speed(), 0.7);
}

TEST(Panel, RejectsASpeedAboveItsRange) {
  takt::testing::Module module;
  ASSERT_TRUE(module.set("speed", "3"));
  const std::string problem = module.start().text();
  EXPECT_NE(problem.find("property 'speed' cannot be '3'; it takes a number, 0 to 2, in m/s"),
            std::string::npos)
      << problem;
}

}  // namespace
