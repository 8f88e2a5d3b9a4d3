#include "contender.hpp"

#include <gtest/gtest.h>

namespace takt::schedule::contender_test {
namespace {

using namespace std::chrono_literals;

// The table has three rows, with 1, 5 and 2 ns of work. A row begins every 10 ns.
TEST(RowDemand, IsTheSumOfTheFullestConsecutiveRows) {
  const RowDemand rows{{1, 5, 2}, 10ns, 0ns};
  EXPECT_TRUE(rows.in(0) == 0);
  EXPECT_TRUE(rows.in(1) == 5);
  EXPECT_TRUE(rows.in(10) == 5);
  EXPECT_TRUE(rows.in(11) == 7);
  EXPECT_TRUE(rows.in(21) == 8);
  EXPECT_TRUE(rows.in(31) == 13) << "all rows, and the fullest again";
}

TEST(RowDemand, IncludesTheSpinningOfEachRow) {
  const RowDemand rows{{1, 5, 2}, 10ns, 3ns};
  EXPECT_TRUE(rows.in(11) == 7 + 2 * 3);
}

TEST(RowDemand, IsASafeUpperBoundForALongTable) {
  std::vector<Wide> work(10'000, 1);
  work[17] = 6;
  work[18] = 6;
  const RowDemand rows{work, 10ns, 0ns};
  EXPECT_TRUE(rows.in(1) == 6);
  EXPECT_TRUE(rows.in(20) >= 12);
  EXPECT_TRUE(rows.in(Wide{100'000}) == 10'010);
}

TEST(RecurringWork, IncludesEveryReleaseInTheWindow) {
  const Recurring job{.work = 3, .apart = 10, .jitter = 4, .response = 8};
  EXPECT_TRUE(job.fresh(1) == 3);
  EXPECT_TRUE(job.fresh(6) == 3);
  EXPECT_TRUE(job.fresh(7) == 6) << "a delayed release, and the next on time";
}

// Before the window, one release runs as late as its response time of 8 ns allows, so its 3 ns of work are at
// the beginning of the window. The work of the next release begins 5 ns after the beginning of the window.
TEST(RecurringWork, CanIncludeReleasesFromBeforeTheWindow) {
  const Recurring job{.work = 3, .apart = 10, .jitter = 0, .response = 8};
  EXPECT_TRUE(job.carried(3) == 3);
  EXPECT_TRUE(job.carried(5) == 3);
  EXPECT_TRUE(job.carried(6) == 4);
  EXPECT_TRUE(job.carried(8) == 6);
}

TEST(Contender, CanIncludeRowsReleasedBeforeTheWindow) {
  Contender rows;
  rows.rows = RowDemand{{4}, 10ns, 2ns};
  rows.rows_response = 9;
  EXPECT_TRUE(rows.fresh(9) == 6);
  EXPECT_TRUE(rows.carried(9) == 12)
      << "released at most 9 ns before the window, and spinning since 11 ns before it";
}

TEST(RecurringWork, FillsTheWholeWindowIfItOverloadsTheCpu) {
  EXPECT_TRUE((Recurring{.work = 30, .apart = 10, .response = 10}.carried(100)) == 100);
  EXPECT_TRUE((Recurring{.work = 1, .apart = 0}.fresh(1)) >= kForever);
}

}  // namespace
}  // namespace takt::schedule::contender_test
