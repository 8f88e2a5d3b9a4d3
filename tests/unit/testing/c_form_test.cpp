// Tests the test harness with a thread module in C.
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <basic.hpp>

namespace c_form_test {
namespace {

using takt::lifecycle::State;
using takt::testing::Module;

basic::Number number(double value) {
  basic::Number result;
  result.value(value);
  return result;
}

TEST(ModuleInC, ReadsItsInputsAndWritesItsOutputs) {
  Module module{{.file = C_FORM}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(10));
  module.step(3);
  EXPECT_EQ(out.value().value(), 12);
}

TEST(ModuleInC, ReadsASafeValueOnlyOnce) {
  Module module{{.file = C_FORM}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  in.safe(number(100));
  ASSERT_TRUE(module.start());
  module.step(3);
  EXPECT_EQ(out.value().value(), 100 + 2);
  in.write(number(10));
  module.step(2);
  EXPECT_EQ(out.value().value(), 110 + 4);
  in.lose();
  module.step(2);
  EXPECT_EQ(out.value().value(), 210 + 6);
}

TEST(ModuleInC, SharesNoVariablesWithAnotherInstance) {
  Module one{{.file = C_FORM}};
  Module other{{.file = C_FORM}};
  auto& in = one.in<basic::Number>("in");
  auto& out = other.out<basic::Number>("out");
  ASSERT_TRUE(one.start());
  ASSERT_TRUE(other.start());
  in.write(number(10));
  one.step();
  other.step();
  EXPECT_EQ(out.value().value(), 0);
}

TEST(ModuleInC, StartsWithNewVariablesAfterAReset) {
  Module module{{.file = C_FORM}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(10));
  module.step();
  ASSERT_TRUE(module.destruct());
  ASSERT_TRUE(module.reset());
  ASSERT_TRUE(module.start());
  module.step();
  EXPECT_EQ(out.value().value(), 1);  // the sum, which is 0 after the reset, plus the cycle number
}

TEST(ModuleInC, ReportsTheReasonOfAFailure) {
  Module module{{.file = C_FORM}};
  auto& in = module.in<basic::Number>("in");
  ASSERT_TRUE(module.start());
  in.write(number(-1));
  module.step();
  EXPECT_EQ(module.state(), State::recover);
  EXPECT_EQ(module.last_error().text, "the sum is negative");
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.step(2), 2U);
}

TEST(ModuleInC, EndsAfterTheCycleInWhichItFinishes) {
  Module module{{.file = C_FORM}};
  auto& in = module.in<basic::Number>("in");
  auto& out = module.out<basic::Number>("out");
  ASSERT_TRUE(module.start());
  in.write(number(2000));
  EXPECT_EQ(module.step(3), 1U);
  EXPECT_EQ(module.state(), State::destruct);
  EXPECT_EQ(out.value().value(), 2000);
  EXPECT_TRUE(module.healthy());
}

TEST(ModuleInC, AcceptsPropertiesOnlyBeforeItIsInitialized) {
  Module module{{.file = C_FORM}};
  ASSERT_TRUE(module.set("anything", "1"));
  ASSERT_TRUE(module.start());
  EXPECT_FALSE(module.set("anything", "2"));
  EXPECT_EQ(*module.get("anything"), "1");
  EXPECT_FALSE(module.get("nothing"));
}

}  // namespace
}  // namespace c_form_test
