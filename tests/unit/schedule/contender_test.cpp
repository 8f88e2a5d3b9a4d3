#include "contender.hpp"

#include <gtest/gtest.h>

namespace takt::schedule::contender_test {
namespace {

using namespace std::chrono_literals;

// Rows of 1, 5 and 2, ten apart.
TEST(RowDemand, IsTheFullestStretchOfTheCircle) {
  const RowDemand rows{{1, 5, 2}, 10ns, 0ns};
  EXPECT_TRUE(rows.in(0) == 0);
  EXPECT_TRUE(rows.in(1) == 5);
  EXPECT_TRUE(rows.in(10) == 5);
  EXPECT_TRUE(rows.in(11) == 7);
  EXPECT_TRUE(rows.in(21) == 8);
  EXPECT_TRUE(rows.in(31) == 13) << "all of them, and the fullest again";
}

TEST(RowDemand, BringsItsSpinningWithEachRow) {
  const RowDemand rows{{1, 5, 2}, 10ns, 3ns};
  EXPECT_TRUE(rows.in(11) == 7 + 2 * 3);
}

TEST(RowDemand, OfALongTableIsNoLessThanItsRows) {
  std::vector<Wide> work(10'000, 1);
  work[17] = 6;
  work[18] = 6;
  const RowDemand rows{work, 10ns, 0ns};
  EXPECT_TRUE(rows.in(1) == 6);
  EXPECT_TRUE(rows.in(20) >= 12);
  EXPECT_TRUE(rows.in(Wide{100'000}) == 10'010);
}

TEST(Recurring, CountsWhatComesInTheWindow) {
  const Recurring job{.work = 3, .apart = 10, .jitter = 4, .response = 8};
  EXPECT_TRUE(job.fresh(1) == 3);
  EXPECT_TRUE(job.fresh(6) == 3);
  EXPECT_TRUE(job.fresh(7) == 6) << "one that was held up, and the next on time";
}

// It is just being done at its latest, 8 after its release: 3 from the beginning of the window, the next
// from 5.
TEST(Recurring, CountsWhatIsLeftOfAnEarlierRelease) {
  const Recurring job{.work = 3, .apart = 10, .jitter = 0, .response = 8};
  EXPECT_TRUE(job.carried(3) == 3);
  EXPECT_TRUE(job.carried(5) == 3);
  EXPECT_TRUE(job.carried(6) == 4);
  EXPECT_TRUE(job.carried(8) == 6);
}

TEST(Contender, CarriesRowsThatWereReleasedBeforeTheWindow) {
  Contender rows;
  rows.rows = RowDemand{{4}, 10ns, 2ns};
  rows.rows_response = 9;
  EXPECT_TRUE(rows.fresh(9) == 6);
  EXPECT_TRUE(rows.carried(9) == 12) << "released 9 before at most, spinning from 11 before";
}

TEST(Contender, ThatSleepsBetweenGoesBeforeAnEqualOnce) {
  Contender program;
  program.kind = Contender::Kind::program;
  program.jobs = {{.work = 3, .apart = 10, .response = 10}};
  EXPECT_TRUE(program.before_equal(100) > 30);
  program.sleeps_between = true;
  EXPECT_TRUE(program.before_equal(100) == 3);
}

TEST(Recurring, ThatNeverEndsTakesTheWholeWindow) {
  EXPECT_TRUE((Recurring{.work = 30, .apart = 10, .response = 10}.carried(100)) == 100);
  EXPECT_TRUE((Recurring{.work = 1, .apart = 0}.fresh(1)) >= kForever);
}

}  // namespace
}  // namespace takt::schedule::contender_test
