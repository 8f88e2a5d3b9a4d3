#include "pace.hpp"

#include <gmock/gmock.h>

namespace pace_test {
namespace {

using namespace takt::dds;
using namespace std::chrono_literals;

constexpr std::uint64_t kAnna = 1;
constexpr std::uint64_t kEve = 2;

int taken(Pace& pace, std::uint64_t asker, int commands, Pace::Clock::time_point now) {
  int count = 0;
  for (int i = 0; i < commands; ++i) count += pace.admit(asker, now) ? 1 : 0;
  return count;
}

TEST(Pace, TakesWhatComesAtOnceUpToItsBound) {
  Pace pace{{10, 5}, {100, 50}};
  EXPECT_EQ(taken(pace, kAnna, 100, {}), 5);
}

TEST(Pace, TakesMoreAsTimePasses) {
  Pace pace{{10, 5}, {100, 50}};
  const Pace::Clock::time_point begin{};
  taken(pace, kAnna, 100, begin);
  EXPECT_EQ(taken(pace, kAnna, 100, begin + 99ms), 0);
  EXPECT_EQ(taken(pace, kAnna, 100, begin + 300ms), 3);
  EXPECT_EQ(taken(pace, kAnna, 100, begin + 1h), 5) << "no more than at once, however long nobody asked";
}

TEST(Pace, WhoAsksTooMuchTakesNothingFromTheOthers) {
  Pace pace{{10, 5}, {100, 50}};
  taken(pace, kEve, 100000, {});
  EXPECT_EQ(taken(pace, kAnna, 5, {}), 5);
}

TEST(Pace, AllTogetherHaveABoundToo) {
  Pace pace{{10, 5}, {100, 50}};
  int all = 0;
  for (std::uint64_t asker = 0; asker < 100; ++asker) all += taken(pace, asker, 5, {});
  EXPECT_EQ(all, 50);
}

TEST(Pace, ManyAskersAreForgottenAgain) {
  Pace pace{{10, 5}, {1e9, 1e9}};
  Pace::Clock::time_point now{};
  for (std::uint64_t asker = 0; asker < 10000; ++asker) EXPECT_EQ(taken(pace, asker, 1, now += 1us), 1);
}

TEST(Pace, ATimeThatGoesBackTakesNothingAway) {
  Pace pace{{10, 5}, {100, 50}};
  const Pace::Clock::time_point now = Pace::Clock::time_point{} + 1h;
  EXPECT_TRUE(pace.admit(kAnna, now));
  EXPECT_TRUE(pace.admit(kAnna, now - 1s));
}

}  // namespace
}  // namespace pace_test
