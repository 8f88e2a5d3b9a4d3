// Tests the test harness with a sporadic program in C, in the form of the paper's Figure 11.
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <basic.hpp>

namespace sporadic_program_test {
namespace {

using takt::testing::Module;

TEST(SporadicProgram, RunsItsBodyWhenItsConditionIsTrue) {
  Module module{{.sporadic = true}};
  auto& order = module.in<basic::Count>("order");
  auto& bodies = module.out<basic::Count>("bodies");
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(9), 9U);  // step() returns the number of releases
  EXPECT_EQ(bodies.value().value(), 3);
  basic::Count ordered;
  ordered.value(10);
  order.write(ordered);
  module.step();
  EXPECT_EQ(bodies.value().value(), 13);
}

TEST(SporadicProgram, UsesANewPropertyValueFromTheNextBodyOn) {
  Module module{{.sporadic = true}};
  auto& bodies = module.out<basic::Count>("bodies");
  ASSERT_TRUE(module.start());
  EXPECT_EQ(*module.get("step"), "1");
  module.step(3);
  EXPECT_EQ(bodies.value().value(), 1);
  ASSERT_TRUE(module.set("step", "20"));
  EXPECT_EQ(*module.get("step"), "20");
  module.step(3);
  EXPECT_EQ(bodies.value().value(), 21);
  EXPECT_EQ(module.set("step", "101").text(),
            "property 'step' cannot be '101'; it takes a whole number, 1 to 100");
  EXPECT_EQ(module.set("stop", "1").text(), "this program has no property 'stop'; did you mean step?");
  module.step(3);
  EXPECT_EQ(bodies.value().value(), 41);
}

TEST(SporadicProgram, KeepsTheNewPropertyValueAfterARestart) {
  Module module{{.sporadic = true}};
  auto& bodies = module.out<basic::Count>("bodies");
  ASSERT_TRUE(module.start());
  ASSERT_TRUE(module.set("step", "20"));
  ASSERT_TRUE(module.crash());
  EXPECT_EQ(module.set("step", "30").text(), "the program has ended; set the property after recover()");
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(*module.get("step"), "20");
  module.step(3);
  EXPECT_EQ(bodies.value().value(), 20);
}

TEST(SporadicProgram, FailsToStartInAPeriodicTest) {
  Module module;
  EXPECT_NE(module.start().text().find("initSporadicExe(): the test declares the module periodic"),
            std::string::npos);
}

}  // namespace
}  // namespace sporadic_program_test
