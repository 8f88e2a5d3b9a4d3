#include "grip.hpp"

#include <gtest/gtest.h>

#include <takt/testing.hpp>

#include <basic.hpp>

namespace gripper {
namespace {

constexpr double kPeriod = 1e-3;

/// Returns the fingers after they have moved for this many seconds.
Fingers after(Fingers fingers, double seconds, bool close, bool part) {
  for (int i = 0; i < static_cast<int>(seconds / kPeriod + 0.5); ++i) fingers.step(close, part, kPeriod);
  return fingers;
}

TEST(Fingers, HoldAPartAsSoonAsTheyReachIt) {
  EXPECT_FALSE(after({}, 0.399, true, true).holding);
  const Fingers closed = after({}, 0.402, true, true);
  EXPECT_TRUE(closed.holding);
  EXPECT_DOUBLE_EQ(closed.width, 0.04);
  EXPECT_TRUE(after(closed, 10, true, true).holding);
}

TEST(Fingers, CloseCompletelyWithoutAPart) {
  const Fingers closed = after({}, 1, true, false);
  EXPECT_FALSE(closed.holding);
  EXPECT_DOUBLE_EQ(closed.width, 0);
}

TEST(Fingers, DoNotGripAPartThatArrivesAfterTheyClosed) {
  const Fingers closed = after(after({}, 1, true, false), 1, true, true);
  EXPECT_FALSE(closed.holding);
  EXPECT_DOUBLE_EQ(closed.width, 0);
}

TEST(Fingers, CloseWhenAHeldPartDisappears) {
  const Fingers closed = after({}, 1, true, true);
  EXPECT_FALSE(after(closed, kPeriod, true, false).holding);
  EXPECT_DOUBLE_EQ(after(closed, 1, true, false).width, 0);
}

TEST(Fingers, ReleaseTheirPartAtOnceWhenTheyOpen) {
  const Fingers closed = after({}, 1, true, true);
  const Fingers opening = after(closed, kPeriod, false, true);
  EXPECT_FALSE(opening.holding);
  EXPECT_NEAR(opening.width, 0.0401, 1e-9);
  EXPECT_DOUBLE_EQ(after(closed, 1, false, true).width, 0.08);
}

TEST(Fingers, CanHoldAPartAsWideAsTheirStroke) {
  EXPECT_TRUE(after({.part_width = 0.08}, kPeriod, true, true).holding);
}

basic::Flag flag(bool value) {
  basic::Flag one;
  one.value(value);
  return one;
}

TEST(Gripper, IsOpenUntilTheFirstCloseCommand) {
  takt::testing::Module module;
  ASSERT_TRUE(module.set("stroke", "0.06"));
  auto& width = module.out<basic::Number>("width");
  auto& holding = module.out<basic::Flag>("holding");
  ASSERT_TRUE(module.start());
  module.step(100);
  EXPECT_DOUBLE_EQ(width.value().value(), 0.06);
  EXPECT_FALSE(holding.value().value());
}

TEST(Gripper, AssumesAPartIfPartPresentIsNotConnected) {
  takt::testing::Module module;
  auto& close = module.in<basic::Flag>("close");
  auto& holding = module.out<basic::Flag>("holding");
  auto& width = module.out<basic::Number>("width");
  ASSERT_TRUE(module.start());
  close.write(flag(true));
  ASSERT_TRUE(module.step_until([&] { return holding.value().value(); }, 1000));
  EXPECT_NEAR(static_cast<double>(module.runs()), 400, 1);
  EXPECT_DOUBLE_EQ(width.value().value(), 0.04);
}

TEST(Gripper, HoldsAPartOnlyWhileItIsPresent) {
  takt::testing::Module module;
  auto& close = module.in<basic::Flag>("close");
  auto& there = module.in<basic::Flag>("part_present");
  auto& holding = module.out<basic::Flag>("holding");
  ASSERT_TRUE(module.start());
  close.write(flag(true));
  module.step(1000);
  EXPECT_FALSE(holding.value().value());
  close.write(flag(false));
  there.write(flag(true));
  module.step(1000);
  close.write(flag(true));
  module.step(1000);
  EXPECT_TRUE(holding.value().value());
  there.write(flag(false));
  module.step();
  EXPECT_FALSE(holding.value().value());
}

TEST(Gripper, RejectsAPartWidthAboveTheStroke) {
  takt::testing::Module module;
  ASSERT_TRUE(module.set("part_width", "0.1"));
  EXPECT_EQ(
      module.start().text(),
      "a part of 0.1 m does not fit between fingers that open 0.08 m; increase stroke or reduce part_width");
}

}  // namespace
}  // namespace gripper
