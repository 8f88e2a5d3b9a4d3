#include "expected.hpp"

#include <gtest/gtest.h>

namespace panel {
namespace {

/// Lets time pass in steps of 0.1 s.
void pass(Expected& expected, double seconds, bool permitted = true) {
  for (int i = 0; i < static_cast<int>(seconds * 10 + 0.5); ++i) expected.pass(0.1, permitted);
}

TEST(PartPrediction, IsOffIfTheTimeToBringAPartIsZero) {
  Expected expected;
  expected.planned({.number = 1, .placed = 2, .ended = 3});
  pass(expected, 100);
  EXPECT_EQ(expected.parts(), 0U);
  EXPECT_EQ(expected.part_time(), 0);
}
TEST(PartPrediction, CountsAPartWhenItShouldBePlaced) {
  Expected expected;
  expected.bring(1);
  pass(expected, 1);
  EXPECT_EQ(expected.parts(), 0U);
  expected.planned({.number = 1, .placed = 2, .ended = 2.5});
  pass(expected, 1.9);
  EXPECT_EQ(expected.parts(), 0U);
  pass(expected, 0.2);
  EXPECT_EQ(expected.parts(), 1U);
}
TEST(PartPrediction, AssumesThatFurtherPartsTakeAsLongAsTheLast) {
  Expected expected;
  expected.bring(1);
  expected.planned({.number = 1, .placed = 2, .ended = 2.5});
  pass(expected, 30.1);  // each part takes 3 s
  EXPECT_EQ(expected.parts(), 10U);
}
TEST(PartPrediction, AssumesThatAPartStartsOnlyWhenTheArmIsHome) {
  Expected expected;
  expected.bring(1);
  expected.planned({.number = 1, .placed = 2, .ended = 4});
  expected.planned({.number = 2, .placed = 2, .ended = 4});
  pass(expected, 6.9);  // part 1: 1 s to bring, 2 s to place; part 2: 2 s until the arm is home, 2 s to place
  EXPECT_EQ(expected.parts(), 1U);
  pass(expected, 0.2);
  EXPECT_EQ(expected.parts(), 2U);
}
TEST(PartPrediction, ExcludesTheTimeOfAnEmergencyStop) {
  Expected expected;
  expected.bring(1);
  expected.planned({.number = 1, .placed = 2, .ended = 2});
  pass(expected, 2);
  pass(expected, 50, false);
  EXPECT_EQ(expected.parts(), 0U);
  EXPECT_NEAR(expected.stopped(), 50, 1e-9);
  pass(expected, 1.1);
  EXPECT_EQ(expected.parts(), 1U);
}
TEST(PartPrediction, IgnoresARepeatedPlan) {
  Expected expected;
  expected.bring(1);
  for (int i = 0; i < 5; ++i) expected.planned({.number = 1, .placed = 2, .ended = 2});
  pass(expected, 5.9);
  EXPECT_EQ(expected.parts(), 1U);
}

}  // namespace
}  // namespace panel
