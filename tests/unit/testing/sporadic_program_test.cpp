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

TEST(SporadicProgram, FailsToStartInAPeriodicTest) {
  Module module;
  EXPECT_NE(module.start().text().find("initSporadicExe(): the test declares the module periodic"),
            std::string::npos);
}

}  // namespace
}  // namespace sporadic_program_test
