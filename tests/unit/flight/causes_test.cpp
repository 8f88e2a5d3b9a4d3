#include "causes.hpp"

#include <gtest/gtest.h>

#include <set>

#include "recordings.hpp"

namespace takt::flight::causes_test {
namespace {

using namespace std::chrono_literals;
constexpr std::int64_t kMs = Made::kMs;
constexpr std::int64_t kUs = Made::kUs;

std::vector<LateStart> judged(const Made& made) {
  const auto line = timeline_of(made.recording.executors[0].threads[0], true, 0);
  return late_starts(made.recording, 0, line);
}

/// Returns a recording of a hundred rows on time, one row that begins 300 us late, and a hundred more rows on
/// time.
Made one_late_row() {
  Made made;
  made.good(0, 100);
  made.row(100 * kMs, 300 * kUs, {{0, 40 * kUs}, {1, 60 * kUs}});
  made.good(101, 100);
  return made;
}

TEST(LatenessDiagnosis, ReportsNothingIfNothingIsLate) {
  Made made;
  made.good(0, 1000);
  EXPECT_TRUE(judged(made).empty());
}

TEST(LatenessDiagnosis, ReportsNothingForAnEmptyRecording) {
  EXPECT_TRUE(judged(Made{}).empty());
  Made one;
  one.good(5, 1);
  EXPECT_TRUE(judged(one).empty());
}

TEST(LatenessDiagnosis, ReportsOnlyDelaysAboveTheThreshold) {
  for (const std::int64_t late : {20 * kUs, 20 * kUs + 1}) {
    Made made;
    made.good(0, 10);
    made.row(10 * kMs, late, {{0, 40 * kUs}});
    EXPECT_EQ(judged(made).size(), late > 20 * kUs ? 1U : 0U) << late;
  }
}

TEST(LatenessDiagnosis, DoesNotReportDelaysOfUsualLength) {
  Made made;
  for (std::int64_t i = 0; i < 100; ++i) made.row(i * kMs, (15 + i % 10) * kUs, {{0, 40 * kUs}});
  made.row(100 * kMs, 190 * kUs, {{0, 40 * kUs}});
  EXPECT_TRUE(judged(made).empty());
  made.row(101 * kMs, 250 * kUs, {{0, 40 * kUs}});
  EXPECT_EQ(judged(made).size(), 1U);
}

TEST(LatenessDiagnosis, NamesTheModuleThatRanTooLongInThePreviousRow) {
  Made made;
  made.good(0, 100);
  made.row(100 * kMs, 100, {{0, 40 * kUs}, {1, 1500 * kUs}});
  made.row(101 * kMs, 540 * kUs + 100, {{0, 40 * kUs}, {1, 60 * kUs}});
  made.good(102, 10);
  const auto late = judged(made);
  ASSERT_EQ(late.size(), 1U);
  EXPECT_EQ(late[0].cause, Cause::own_overrun);
  EXPECT_FALSE(late[0].run);
  EXPECT_EQ(late[0].culprit, 1U);
  EXPECT_EQ(late[0].took, 1500us);
  EXPECT_EQ(late[0].usual, 60us);
  EXPECT_EQ(in_words(late[0], made.recording.modules),
            "m1 ran 1.50 ms in the previous row (usually 60.0 us)");
}

TEST(LatenessDiagnosis, MeasuresADelayFromTheFirstMissedRow) {
  Made made;
  made.good(0, 100);
  made.row(100 * kMs, 100, {{0, 3100 * kUs}});
  made.row(103 * kMs, 100 * kUs + 100, {{0, 40 * kUs}, {1, 60 * kUs}});
  const auto late = judged(made);
  ASSERT_EQ(late.size(), 1U);
  EXPECT_EQ(late[0].missed, 2U);
  EXPECT_EQ(late[0].late, 2100us + 100ns);
  EXPECT_EQ(late[0].cause, Cause::own_overrun);
}

TEST(LatenessDiagnosis, BlamesAnEarlierRunInTheSameRowThatTookTooLong) {
  Made made;
  made.good(0, 100);
  made.row(100 * kMs, 100, {{0, 440 * kUs}, {1, 60 * kUs}});
  made.good(101, 100);
  const auto late = judged(made);
  ASSERT_EQ(late.size(), 1U);
  EXPECT_EQ(late[0].cause, Cause::predecessor);
  EXPECT_TRUE(late[0].run);
  EXPECT_EQ(late[0].late, 400us);
  EXPECT_EQ(late[0].culprit, 0U);
  EXPECT_EQ(in_words(late[0], made.recording.modules), "m0 ran 440 us before it (usually 40.0 us)");
}

TEST(LatenessDiagnosis, ShowsTheBudgetOfTheModuleThatRanTooLong) {
  Made made;
  made.recording.modules[0].budget = 50us;
  made.good(0, 100);
  made.row(100 * kMs, 100, {{0, 440 * kUs}, {1, 60 * kUs}});
  EXPECT_EQ(in_words(judged(made)[0], made.recording.modules),
            "m0 ran 440 us before it (usually 40.0 us, budget 50.0 us)");
}

TEST(LatenessDiagnosis, GivesNoCauseWithoutSamples) {
  const auto late = judged(one_late_row());
  ASSERT_EQ(late.size(), 1U);
  EXPECT_EQ(late[0].cause, Cause::unknown);
}

TEST(LatenessDiagnosis, GivesNoCauseWithoutSamplesBeforeAndAfterTheDelay) {
  for (const std::int64_t at : {99 * kMs, 102 * kMs}) {
    Made made = one_late_row();
    made.sample(at);
    EXPECT_EQ(judged(made)[0].cause, Cause::unknown) << at;
  }
}

TEST(LatenessDiagnosis, BlamesTheWakeUpIfNoOtherCauseIsFound) {
  Made made = one_late_row();
  made.sample(99 * kMs);
  made.sample(102 * kMs);
  EXPECT_EQ(judged(made)[0].cause, Cause::wake_up);
}

TEST(LatenessDiagnosis, BlamesPreemptionForTimeSpentWaitingForACpu) {
  Made made = one_late_row();
  made.sample(99 * kMs).waited = 1ms;
  made.sample(102 * kMs).waited = 1290us;
  made.sample(150 * kMs).waited = 1290us;
  made.sample(200 * kMs).waited = 1290us;
  const auto late = judged(made);
  EXPECT_EQ(late[0].cause, Cause::preemption);
  EXPECT_EQ(in_words(late[0], made.recording.modules), "waited 290 us for a CPU");
}

TEST(LatenessDiagnosis, NamesAShortWaitForACpuIfItIsTheCause) {
  Made made;
  made.good(0, 100);
  made.row(100 * kMs, 30 * kUs, {{0, 40 * kUs}, {1, 60 * kUs}});
  made.good(101, 100);
  made.sample(99 * kMs).waited = 1ms;
  for (const std::int64_t at : {102, 150, 200}) made.sample(at * kMs).waited = 1018us;
  const auto late = judged(made);
  EXPECT_EQ(late[0].cause, Cause::preemption);
  EXPECT_EQ(in_words(late[0], made.recording.modules), "waited 18.0 us for a CPU");
}

TEST(LatenessDiagnosis, IgnoresTheUsualWaitForACpu) {
  Made made = one_late_row();
  for (std::int64_t i = 0; i < 10; ++i) made.sample((93 + 2 * i) * kMs).waited = 290us * i;
  EXPECT_EQ(judged(made)[0].cause, Cause::wake_up);
}

TEST(LatenessDiagnosis, TreatsAStoppedProcessAsPreempted) {
  Made made = one_late_row();
  made.sample(99 * kMs);
  made.sample(100 * kMs + 100 * kUs).stopped = true;
  made.sample(102 * kMs);
  EXPECT_EQ(judged(made)[0].cause, Cause::preemption);
}

TEST(LatenessDiagnosis, BlamesManyPageFaults) {
  Made made = one_late_row();
  made.sample(99 * kMs).minor_faults = 1000;
  made.sample(102 * kMs).minor_faults = 1200;
  const auto late = judged(made);
  EXPECT_EQ(late[0].cause, Cause::page_fault);
  EXPECT_EQ(in_words(late[0], made.recording.modules), "200 page faults");
}

TEST(LatenessDiagnosis, CountsTheTimeThatPageFaultsTakeOnTheMachine) {
  Made made = one_late_row();
  made.sample(99 * kMs);
  made.sample(102 * kMs).minor_faults = 30;
  EXPECT_EQ(judged(made)[0].cause, Cause::wake_up);
  made.recording.minor_fault = 9us;
  EXPECT_EQ(judged(made)[0].cause, Cause::page_fault);
}

TEST(LatenessDiagnosis, DoesNotBlameAFewPageFaultsForALongDelay) {
  Made made = one_late_row();
  made.sample(99 * kMs);
  made.sample(102 * kMs).minor_faults = 3;
  const auto late = judged(made);
  EXPECT_EQ(late[0].cause, Cause::wake_up);
  EXPECT_EQ(in_words(late[0], made.recording.modules), "3 page faults");
}

TEST(LatenessDiagnosis, BlamesTheHypervisorForTimeStolenFromTheExecutorsCpu) {
  Made made = one_late_row();
  made.sample(99 * kMs, 50ms);
  made.sample(102 * kMs, 60ms);
  const auto late = judged(made);
  EXPECT_EQ(late[0].cause, Cause::hypervisor);
  EXPECT_EQ(in_words(late[0], made.recording.modules), "the hypervisor took 10.0 ms");
}

TEST(LatenessDiagnosis, BlamesTheHypervisorIfTheThreadWaitedForACpuThatTheHypervisorTook) {
  Made made = one_late_row();
  made.sample(99 * kMs, 50ms);
  made.sample(102 * kMs, 60ms).waited = 10150us;
  made.sample(140 * kMs, 60ms).waited = 10150us;
  made.sample(180 * kMs, 60ms).waited = 10150us;
  const auto late = judged(made);
  EXPECT_EQ(late[0].cause, Cause::hypervisor);
  EXPECT_EQ(in_words(late[0], made.recording.modules), "waited 10.2 ms for a CPU; the hypervisor took 10.0 ms");
}

TEST(LatenessDiagnosis, IgnoresTimeStolenFromOtherCpus) {
  Made made = one_late_row();
  made.sample(99 * kMs);
  made.sample(102 * kMs);
  made.recording.samples[1].stolen[0] = 100ms;
  EXPECT_EQ(judged(made)[0].cause, Cause::wake_up);
}

TEST(LatenessDiagnosis, BlamesTheGreaterOfTwoCauses) {
  for (const bool steal : {false, true}) {
    Made made = one_late_row();
    made.sample(99 * kMs);
    made.sample(102 * kMs, steal ? 10ms : 0ms).waited = 250us;
    made.sample(150 * kMs, steal ? 10ms : 0ms).waited = 250us;
    made.sample(160 * kMs, steal ? 10ms : 0ms).waited = 250us;
    made.recording.samples[1].threads[0][0]->minor_faults = 80;
    const auto late = judged(made);
    EXPECT_EQ(late[0].cause, steal ? Cause::hypervisor : Cause::preemption);
    EXPECT_EQ(in_words(late[0], made.recording.modules),
              std::string{"waited 250 us for a CPU; 80 page faults"} +
                  (steal ? "; the hypervisor took 10.0 ms" : ""));
  }
}

TEST(LatenessDiagnosis, BlamesPageFaultsRatherThanTheRunThatTheyProlonged) {
  Made made;
  made.good(0, 100);
  made.row(100 * kMs, 100, {{0, 1940 * kUs}, {1, 60 * kUs}});
  made.row(102 * kMs, 100, {{0, 40 * kUs}, {1, 60 * kUs}});
  made.sample(99 * kMs);
  made.sample(103 * kMs).minor_faults = 2000;
  const auto late = judged(made);
  ASSERT_EQ(late.size(), 2U);
  EXPECT_EQ(late[0].cause, Cause::page_fault);  // the first late start: m1 in the long row
  EXPECT_EQ(late[1].cause, Cause::page_fault);  // the second late start: the row after the long row
  EXPECT_EQ(late[1].culprit, 0U);
  EXPECT_EQ(in_words(late[1], made.recording.modules),
            "m0 ran 1.94 ms in the previous row (usually 40.0 us); 1 row missed; 2000 page faults");
}

TEST(LatenessDiagnosis, CarriesTheCauseOverToTheNextLateRow) {
  Made made;
  made.good(0, 100);
  made.row(100 * kMs, 950 * kUs, {{0, 40 * kUs}, {1, 60 * kUs}});
  made.row(101 * kMs, 51 * kUs, {{0, 40 * kUs}, {1, 60 * kUs}});
  made.sample(99 * kMs);
  made.sample(103 * kMs);
  const auto late = judged(made);
  ASSERT_EQ(late.size(), 2U);
  EXPECT_EQ(late[0].cause, Cause::wake_up);
  EXPECT_EQ(late[1].cause, Cause::wake_up);
}

TEST(LatenessDiagnosis, DoesNotReportRowsMissedDuringAHostRestart) {
  Made made;
  made.good(0, 100);
  made.row(100 * kMs, 100, {{0, 40 * kUs}}, false);
  made.good(500, 10);
  EXPECT_TRUE(judged(made).empty());
}

TEST(LatenessDiagnosis, HasADistinctTextForEachCause) {
  std::set<std::string> words;
  for (const Cause cause : kCauses) words.insert(to_text(cause));
  EXPECT_EQ(words.size(), kCauses.size());
}

TEST(ShortTime, HasThreeSignificantDigits) {
  EXPECT_EQ(in_short(999ns), "999 ns");
  EXPECT_EQ(in_short(1us), "1.00 us");
  EXPECT_EQ(in_short(99'960ns), "100 us");
  EXPECT_EQ(in_short(999'499ns), "999 us");
  EXPECT_EQ(in_short(999'500ns), "1.00 ms");
  EXPECT_EQ(in_short(12'345us), "12.3 ms");
  EXPECT_EQ(in_short(61s), "61.0 s");
}

}  // namespace
}  // namespace takt::flight::causes_test
