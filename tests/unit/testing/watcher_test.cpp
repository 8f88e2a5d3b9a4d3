// Tests the test harness with a sporadic C++ component.
#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <basic.hpp>

namespace watcher_test {
namespace {

using takt::lifecycle::State;
using takt::testing::Module;
using namespace std::chrono_literals;

basic::Number number(double value) {
  basic::Number result;
  result.value(value);
  return result;
}

TEST(SporadicComponent, RunsWhenAnEventArrives) {
  Module module{{.sporadic = true, .file = WATCHER}};
  auto& alarm = module.in<basic::Number>("alarm");
  auto& sum = module.out<basic::Number>("sum");
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(10), 0U);
  EXPECT_EQ(module.state(), State::start);
  alarm.write(number(1));
  alarm.write(number(2));
  EXPECT_EQ(module.step(10), 1U);
  EXPECT_EQ(module.state(), State::executing);
  EXPECT_EQ(sum.value().value(), 3);
}

TEST(SporadicComponent, RunsWhileItsConditionIsTrue) {
  Module module{{.sporadic = true, .file = WATCHER}};
  auto& level = module.in<basic::Number>("level");
  ASSERT_TRUE(module.start());
  level.write(number(11));
  EXPECT_EQ(module.step(10), 10U);
  level.write(number(10));
  EXPECT_EQ(module.step(10), 0U);
}

TEST(SporadicComponent, GoesToRecoverWhenItsConditionFails) {
  Module module{{.sporadic = true, .file = WATCHER}};
  ASSERT_TRUE(module.start());
  module.step();
  ASSERT_TRUE(module.set("fails", "true"));
  EXPECT_EQ(module.step(3), 0U);
  EXPECT_EQ(module.state(), State::recover);
  EXPECT_EQ(module.last_error().text, "the condition failed");
  EXPECT_EQ(module.last_error().cycle, 1U);
  ASSERT_TRUE(module.set("fails", "false"));
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.state(), State::start);
}

TEST(SafeValue, IsReadBeforeTheFirstSampleAndAfterTheWriterIsLost) {
  Module module{{.sporadic = true, .file = WATCHER}};
  auto& level = module.in<basic::Number>("level");
  level.safe(number(11));  // the module runs while its input `level` is above 10
  ASSERT_TRUE(module.start());
  EXPECT_EQ(module.step(5), 5U);
  level.write(number(1));
  EXPECT_EQ(module.step(5), 0U);
  level.lose();
  EXPECT_EQ(module.step(5), 5U);
  level.write(number(2));
  EXPECT_EQ(module.step(5), 0U);
}

TEST(SafeValue, ReplacesASampleOlderThanTheDeadline) {
  Module module{{.period = 1ms, .sporadic = true, .file = WATCHER}};
  auto& level = module.in<basic::Number>("level", {.deadline = 3ms});
  level.safe(number(11));
  ASSERT_TRUE(module.start());
  level.write(number(1));  // the sample gets the time of the next release as its time
  EXPECT_EQ(module.step(4), 0U) << "a sample as old as the deadline is still valid";
  EXPECT_EQ(module.step(1), 1U);
  level.write(number(1), 3ms + 1ns);
  EXPECT_EQ(module.step(1), 1U) << "the sample is older than the deadline";
  level.write(number(1), 3ms);
  EXPECT_EQ(module.step(1), 0U);
}

TEST(SafeValue, IsRejectedForAQueue) {
  Module module{{.sporadic = true, .file = WATCHER}};
  auto& alarm = module.in<basic::Number>("alarm");
  EXPECT_THROW(alarm.safe(number(1)), takt::testing::Error);
}

}  // namespace
}  // namespace watcher_test
