#include "watch.hpp"

#include <gtest/gtest.h>

namespace takt::supervision::watch_test {
namespace {

using namespace std::chrono_literals;

TEST(Watch, MeasuresHowLongAValueStaysTheSame) {
  Watch watch;
  EXPECT_EQ(watch.look(7, 5ms, 100ms), 0ms) << "the value was not seen before";
  EXPECT_EQ(watch.look(7, 5ms, 100ms), 5ms);
  EXPECT_EQ(watch.look(7, 6ms, 100ms), 11ms);
  EXPECT_EQ(watch.look(8, 5ms, 100ms), 0ms);
  EXPECT_EQ(watch.look(8, 5ms, 100ms), 5ms);
}

TEST(Watch, CountsAPauseOfTheMachineForAtMostAQuarterOfTheLimit) {
  Watch watch;
  watch.look(7, 5ms, 20ms);
  EXPECT_EQ(watch.look(7, 10s, 20ms), 5ms);
  EXPECT_EQ(watch.look(7, 5ms, 20ms), 10ms);
}

TEST(Watch, DoesNotCountTheTimeInWhichTheThreadWaitsForACpu) {
  Watch watch;
  watch.look(7, 5ms, 100ms, 40ms);
  EXPECT_EQ(watch.look(7, 5ms, 100ms, 42ms), 2ms);
  EXPECT_EQ(watch.look(7, 5ms, 100ms, 42ms), 2ms);
  EXPECT_EQ(watch.look(7, 5ms, 100ms), 7ms) << "the thread sleeps, so it does not wait for a CPU";
  EXPECT_EQ(watch.look(7, 5ms, 100ms, 43ms), 8ms);
}

}  // namespace
}  // namespace takt::supervision::watch_test
