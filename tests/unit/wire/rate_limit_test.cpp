#include <takt/wire/rate_limit.hpp>

#include <gmock/gmock.h>

namespace rate_limit_test {
namespace {

using namespace takt::wire;
using namespace std::chrono_literals;

constexpr std::uint64_t kAnna = 1;
constexpr std::uint64_t kEve = 2;

int taken(RateLimit& rate_limit, std::uint64_t client, int commands, RateLimit::Clock::time_point now) {
  int count = 0;
  for (int i = 0; i < commands; ++i) count += rate_limit.admit(client, now) ? 1 : 0;
  return count;
}

TEST(RateLimit, AcceptsABurstUpToItsLimit) {
  RateLimit rate_limit{{10, 5}, {100, 50}};
  EXPECT_EQ(taken(rate_limit, kAnna, 100, {}), 5);
}

TEST(RateLimit, AllowsMoreCommandsAsTimePasses) {
  RateLimit rate_limit{{10, 5}, {100, 50}};
  const RateLimit::Clock::time_point begin{};
  taken(rate_limit, kAnna, 100, begin);
  EXPECT_EQ(taken(rate_limit, kAnna, 100, begin + 99ms), 0);
  EXPECT_EQ(taken(rate_limit, kAnna, 100, begin + 300ms), 3);
  EXPECT_EQ(taken(rate_limit, kAnna, 100, begin + 1h), 5)
      << "never more than the burst, however long the pause";
}

TEST(RateLimit, AGreedyClientDoesNotReduceTheAllowanceOfOthers) {
  RateLimit rate_limit{{10, 5}, {100, 50}};
  taken(rate_limit, kEve, 100000, {});
  EXPECT_EQ(taken(rate_limit, kAnna, 5, {}), 5);
}

TEST(RateLimit, LimitsAllClientsTogether) {
  RateLimit rate_limit{{10, 5}, {100, 50}};
  int all = 0;
  for (std::uint64_t client = 0; client < 100; ++client) all += taken(rate_limit, client, 5, {});
  EXPECT_EQ(all, 50);
}

TEST(RateLimit, AcceptsNewClientsByForgettingOldOnes) {
  RateLimit rate_limit{{10, 5}, {1e9, 1e9}};
  RateLimit::Clock::time_point now{};
  for (std::uint64_t client = 0; client < 10000; ++client)
    EXPECT_EQ(taken(rate_limit, client, 1, now += 1us), 1);
}

TEST(RateLimit, ToleratesAClockThatIsSetBack) {
  RateLimit rate_limit{{10, 5}, {100, 50}};
  const RateLimit::Clock::time_point now = RateLimit::Clock::time_point{} + 1h;
  EXPECT_TRUE(rate_limit.admit(kAnna, now));
  EXPECT_TRUE(rate_limit.admit(kAnna, now - 1s));
}

}  // namespace
}  // namespace rate_limit_test
