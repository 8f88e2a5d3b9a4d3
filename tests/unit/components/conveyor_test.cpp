#include <components/conveyor/belt.hpp>

#include <gtest/gtest.h>

namespace conveyor {
namespace {

constexpr double kPeriod = 2e-3;

TEST(Belt, HoldsEachPartUntilItIsTaken) {
  Belt belt;
  int seen = 0;
  for (int i = 0; i < 5000; ++i) seen += belt.step(0.5, kPeriod) ? 1 : 0;
  EXPECT_EQ(seen, 1);
  EXPECT_TRUE(belt.holding);
  EXPECT_EQ(belt.speed, 0);

  belt.taken(1);
  for (int i = 0; i < 5000; ++i) seen += belt.step(0.5, kPeriod) ? 1 : 0;
  EXPECT_EQ(seen, 2);
  EXPECT_EQ(belt.parts, 2U);
}

TEST(Belt, IsNotReleasedByTheNumberOfAPartThatIsGone) {
  Belt belt;
  while (!belt.step(0.5, kPeriod)) {
  }
  belt.taken(1);
  while (!belt.step(0.5, kPeriod)) {
  }
  belt.taken(1);
  EXPECT_TRUE(belt.holding);
}

TEST(Belt, StopsWhenItIsToldTo) {
  Belt belt;
  for (int i = 0; i < 200; ++i) belt.step(0.5, kPeriod);
  EXPECT_GT(belt.speed, 0.3);
  for (int i = 0; i < 500; ++i) belt.step(0, kPeriod);
  EXPECT_NEAR(belt.speed, 0, 1e-12);
}

TEST(Belt, NeverAcceleratesMoreThanItMay) {
  Belt belt{.acceleration = 0.5};
  double last = 0;
  for (int i = 0; i < 300; ++i) {
    belt.step(2, kPeriod);
    if (belt.holding) break;
    EXPECT_LE(belt.speed - last, 0.5 * kPeriod + 1e-12);
    last = belt.speed;
  }
}

}  // namespace
}  // namespace conveyor
