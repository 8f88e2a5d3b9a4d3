#include "expected.hpp"

#include <gtest/gtest.h>

namespace panel {
namespace {

/// Steps of 0.1 s.
void pass(Expected& expected, double seconds, bool permitted = true) {
  for (int i = 0; i < static_cast<int>(seconds * 10 + 0.5); ++i) expected.pass(0.1, permitted);
}

TEST(Expected, PredictsNothingWithoutABringTime) {
  Expected expected;
  expected.planned({.number = 1, .placed = 2, .ended = 3});
  pass(expected, 100);
  EXPECT_EQ(expected.parts(), 0U);
  EXPECT_EQ(expected.part_time(), 0);
}
TEST(Expected, CountsAPartAfterBringingAndPlacing) {
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
TEST(Expected, ExtrapolatesWithTheTimesOfTheLastPart) {
  Expected expected;
  expected.bring(1);
  expected.planned({.number = 1, .placed = 2, .ended = 2.5});
  pass(expected, 30.1);  // 3 s a part
  EXPECT_EQ(expected.parts(), 10U);
}
TEST(Expected, WaitsUntilTheArmIsHome) {
  Expected expected;
  expected.bring(1);
  expected.planned({.number = 1, .placed = 2, .ended = 4});
  expected.planned({.number = 2, .placed = 2, .ended = 4});
  pass(expected, 6.9);  // 1 to bring and 2 to place, then 2 to go home and 2 to place
  EXPECT_EQ(expected.parts(), 1U);
  pass(expected, 0.2);
  EXPECT_EQ(expected.parts(), 2U);
}
TEST(Expected, ExcludesTheTimeOfAnEmergencyStop) {
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
TEST(Expected, IgnoresARepeatedPlan) {
  Expected expected;
  expected.bring(1);
  for (int i = 0; i < 5; ++i) expected.planned({.number = 1, .placed = 2, .ended = 2});
  pass(expected, 5.9);
  EXPECT_EQ(expected.parts(), 1U);
}

}  // namespace
}  // namespace panel
