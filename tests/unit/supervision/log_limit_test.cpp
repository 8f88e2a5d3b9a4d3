#include "log_limit.hpp"

#include <gtest/gtest.h>

namespace takt::supervision::log_limit_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr Instant kStart = from_ns(1'000'000'000);

/// Offers lines of a level to the limit, all at the same time. Returns how many of them may be recorded.
int taken(LogLimit& limit, LogLevel level, int lines, Instant now) {
  int count = 0;
  for (int i = 0; i < lines; ++i) count += limit.takes(level, now) ? 1 : 0;
  return count;
}

TEST(LogLimit, AcceptsErrorsAndWarningsEvenAfterTooManyInfoLines) {
  LogLimit limit{kStart};
  EXPECT_EQ(taken(limit, LogLevel::info, 1000, kStart), 50);
  EXPECT_EQ(taken(limit, LogLevel::debug, 1000, kStart), 50);
  EXPECT_EQ(taken(limit, LogLevel::error, 50, kStart), 50);
  EXPECT_EQ(taken(limit, LogLevel::warning, 50, kStart), 50);
}

TEST(LogLimit, AcceptsTenLinesPerSecondOnAverage) {
  LogLimit limit{kStart};
  EXPECT_EQ(taken(limit, LogLevel::error, 60, kStart), 50);
  EXPECT_EQ(taken(limit, LogLevel::error, 60, kStart + milliseconds{99}), 0);
  EXPECT_EQ(taken(limit, LogLevel::error, 60, kStart + milliseconds{1000}), 10);
  EXPECT_EQ(taken(limit, LogLevel::error, 60, kStart + seconds{1000}), 50) << "the burst is limited";
}

TEST(LogLimit, ReportsNothingIfItAcceptedEveryLine) {
  LogLimit limit{kStart};
  EXPECT_TRUE(limit.takes(LogLevel::info, kStart));
  EXPECT_FALSE(limit.report(kStart));
}

TEST(LogLimit, CountsTheRejectedLinesOfEachLevel) {
  LogLimit limit{kStart};
  taken(limit, LogLevel::info, 452, kStart);
  taken(limit, LogLevel::error, 53, kStart);
  limit.add_lost({1, 0, 2, 0, 7});
  EXPECT_EQ(
      limit.report(kStart),
      "415 log lines were left out: 1 of unknown level, 3 error, 2 warning, 402 info, 7 debug; a module "
      "can log 10 lines of each level per second");
}

TEST(LogLimit, ReportsAtMostOnceASecond) {
  LogLimit limit{kStart};
  limit.add_lost({0, 0, 0, 3, 0});
  EXPECT_TRUE(limit.report(kStart));
  limit.add_lost({0, 1, 0, 0, 0});
  EXPECT_FALSE(limit.report(kStart + milliseconds{999}));
  EXPECT_EQ(limit.report(kStart + seconds{1}),
            "1 log line was left out: 1 error; a module can log 10 lines of each level per second");
  EXPECT_FALSE(limit.report(kStart + seconds{2}));
}

}  // namespace
}  // namespace takt::supervision::log_limit_test
