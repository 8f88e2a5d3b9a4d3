#include "limit.hpp"

#include <cmath>

#include <cstdio>
#include <string>

#include <gtest/gtest.h>

#include <takt/testing.hpp>

namespace emergency {
namespace {

constexpr double kCheck = 100e-6;

TEST(Limit, ReportsAnEdgeExactlyAtItsThresholds) {
  Limit limit{.trip = 90, .clear = 60};
  EXPECT_FALSE(limit.pending(std::nextafter(90.0, 0.0)));
  EXPECT_TRUE(limit.pending(90));
  limit.serve();
  EXPECT_FALSE(limit.pending(200));
  EXPECT_FALSE(limit.pending(std::nextafter(60.0, 100.0)));
  EXPECT_TRUE(limit.pending(60));
  limit.serve();
  EXPECT_FALSE(limit.pending(60));
}

TEST(Limit, KeepsAnEdgePendingUntilItIsServed) {
  Limit limit{.trip = 90, .clear = 60};
  EXPECT_TRUE(limit.pending(95));
  EXPECT_TRUE(limit.pending(95));
  limit.serve();
  EXPECT_FALSE(limit.pending(95));
}

TEST(Winding, ReachesTheSteadyTemperatureForItsCurrent) {
  Winding winding;
  for (int i = 0; i < 100000; ++i) winding.step(2, kCheck);
  EXPECT_NEAR(winding.temperature, 6, 1e-6);
}

TEST(Drive, TripsInTheStepThatReachesTheLimit) {
  Drive drive;
  while (!drive.condition(kCheck)) ASSERT_LT(drive.winding.temperature, drive.limit.trip);
  EXPECT_GE(drive.winding.temperature, drive.limit.trip);
  EXPECT_LT(drive.winding.temperature, drive.limit.trip + 0.1);
  EXPECT_EQ(drive.trips, 0u);
  drive.react();
  EXPECT_EQ(drive.trips, 1u);
  EXPECT_FALSE(drive.condition(kCheck));
}

TEST(Drive, TripsAFewTimesASecond) {
  Drive drive;
  int reactions = 0;
  for (int i = 0; i < 100000; ++i) {  // 10 s of virtual time
    if (!drive.condition(kCheck)) continue;
    drive.react();
    ++reactions;
  }
  EXPECT_GE(drive.trips, 20u);
  EXPECT_LE(drive.trips, 50u);
  EXPECT_NEAR(reactions, 2 * static_cast<double>(drive.trips), 1);
  EXPECT_LT(drive.hottest, drive.limit.trip + 0.1);
}

TEST(Drive, NeverTripsAtASafeCurrent) {
  Drive drive;
  drive.current = 7;  // in the steady state, the winding is at 73.5 K
  for (int i = 0; i < 100000; ++i) ASSERT_FALSE(drive.condition(kCheck));
}

using namespace std::chrono_literals;

std::uint64_t runs_in_a_second(const char* current) {
  takt::testing::Module module{{.period = 100us, .sporadic = true}};
  EXPECT_TRUE(module.set("current_a", current));
  EXPECT_TRUE(module.start());
  return module.step(10'000);
}

TEST(Emergency, TripsAboutThreeTimesASecond) {
  EXPECT_GE(runs_in_a_second("10"), 4U);  // each trip takes two runs: off and on
  EXPECT_LE(runs_in_a_second("10"), 8U);
}
TEST(Emergency, DoesNotRunWhileTheWindingIsCool) { EXPECT_EQ(runs_in_a_second("5"), 0U); }

TEST(Emergency, StartsColdAfterARecovery) {
  takt::testing::Module module{{.period = 100us, .sporadic = true}};
  ASSERT_TRUE(module.start());
  ASSERT_TRUE(module.step_until([&] { return module.runs() == 1; }, 10'000));
  ASSERT_TRUE(module.error(takt::ErrorType::deadline));
  ASSERT_TRUE(module.recover());
  EXPECT_EQ(module.step(1000), 0U);
}

TEST(Emergency, RejectsAClearLimitAboveTheTripLimit) {
  takt::testing::Module module{{.sporadic = true}};
  ASSERT_TRUE(module.set("clear_k", "95"));
  EXPECT_EQ(module.start().text(), "threw: property 'clear_k' must be below 'trip_k'");
}

}  // namespace
}  // namespace emergency
