#include "timeline.hpp"

#include <gtest/gtest.h>

#include "recordings.hpp"

namespace takt::flight::timeline_test {
namespace {

using channel::FlightKind;
constexpr std::int64_t kMs = Made::kMs;
constexpr std::int64_t kUs = Made::kUs;

Timeline read(const Made& made, std::int64_t from_ns = 0) {
  return timeline_of(made.recording.executors[0].threads[0], true, from_ns);
}

TEST(Timeline, IsEmptyForAnEmptyRecording) {
  const Timeline line = read(Made{});
  EXPECT_TRUE(line.rows.empty() && line.runs.empty() && line.marks.empty() && line.bodies.empty());
}

TEST(Timeline, ListsTheRunsOfEachRow) {
  Made made;
  made.row(5 * kMs, 30, {{0, 40 * kUs}, {2, 60 * kUs}});
  made.row(6 * kMs, 10, {});
  const Timeline line = read(made);
  ASSERT_EQ(line.rows.size(), 2U);
  EXPECT_EQ(line.rows[0].release_ns, 5 * kMs);
  EXPECT_EQ(line.rows[0].late(), Nanoseconds{30});
  EXPECT_EQ(line.rows[0].took(), Nanoseconds{100 * kUs});
  ASSERT_EQ(line.rows[0].end_run - line.rows[0].first_run, 2U);
  EXPECT_EQ(line.runs[1].module, 2U);
  EXPECT_EQ(line.runs[1].start_ns, 5 * kMs + 30 + 40 * kUs);
  EXPECT_EQ(line.rows[1].end_run, line.rows[1].first_run);
  EXPECT_TRUE(line.rows[1].ended);
}

TEST(Timeline, OmitsARowWhoseBeginningWasOverwritten) {
  Made made;
  made.add(FlightKind::run, 4 * kMs, 1, 10);
  made.add(FlightKind::write, 4 * kMs, 1, 0);
  made.add(FlightKind::row_end, 4 * kMs, 0, 0);
  made.good(5, 1);
  const Timeline line = read(made);
  EXPECT_EQ(line.rows.size(), 1U);
  EXPECT_EQ(line.runs.size(), 2U);
  EXPECT_TRUE(line.marks.empty());
}

TEST(Timeline, BeginsAtTheRequestedTime) {
  Made made;
  made.good(0, 10);
  EXPECT_EQ(read(made, 5 * kMs).rows.size(), 5U);
  EXPECT_EQ(read(made, 5 * kMs + 101).rows.size(), 4U);
  EXPECT_EQ(read(made, 50 * kMs).rows.size(), 0U);
}

TEST(Timeline, PlacesReadsAndWritesAtTheBeginningOfTheirRun) {
  Made made;
  made.add(FlightKind::row, 5 * kMs, 0, 0);
  made.add(FlightKind::event, 1, 1, 3);
  made.add(FlightKind::write, 1, 1, 4);
  made.add(FlightKind::run, 5 * kMs + 70, 1, 50);
  made.add(FlightKind::row_end, 5 * kMs + 70, 0, 0);
  const Timeline line = read(made);
  ASSERT_EQ(line.marks.size(), 2U);
  EXPECT_EQ(line.marks[0].kind, FlightKind::event);
  EXPECT_EQ(line.marks[0].time_ns, 5 * kMs + 20);
  EXPECT_EQ(line.marks[1].value, 4U);
}

TEST(Timeline, KeepsTheUnfinishedRunAfterAHostCrash) {
  Made made;
  made.row(5 * kMs, 0, {{0, 40 * kUs}}, false);
  made.recording.executors[0].threads[0].open.push_back({.module = 2,
                                                         .doing = channel::Doing::run,
                                                         .since_ns = 5 * kMs + 40 * kUs,
                                                         .seen_ns = 7 * kMs,
                                                         .host_died = true});
  made.good(100, 3);
  const Timeline line = read(made);
  ASSERT_EQ(line.rows.size(), 4U);
  EXPECT_FALSE(line.rows[0].ended);
  EXPECT_EQ(line.rows[0].end_ns, 7 * kMs);
  ASSERT_EQ(line.rows[0].end_run - line.rows[0].first_run, 2U);
  EXPECT_FALSE(line.runs[1].ended);
  EXPECT_EQ(line.runs[1].module, 2U);
  EXPECT_TRUE(line.rows[1].ended);
}

TEST(Timeline, DoesNotListAFinishedRunAsUnfinishedToo) {
  Made made;
  made.row(5 * kMs, 0, {{0, 40 * kUs}, {1, 50 * kUs}}, false);
  made.recording.executors[0].threads[0].open.push_back(
      {.module = 0, .doing = channel::Doing::run, .since_ns = 5 * kMs, .seen_ns = 5 * kMs + 95 * kUs});
  EXPECT_EQ(read(made).runs.size(), 2U);
}

TEST(Timeline, ListsAProgramRunOnceIfTwoHostsRecordedIt) {
  Made made;
  for (const std::int64_t ended : {3 * kMs, 3 * kMs, 4 * kMs}) {
    made.add(FlightKind::row, 5 * kMs, 0, 0);
    made.add(FlightKind::body, ended, 2, 100 * kUs);
    made.add(FlightKind::row_end, 5 * kMs, 0, 0);
  }
  const Timeline line = read(made);
  ASSERT_EQ(line.bodies.size(), 2U);
  EXPECT_EQ(line.bodies[1].end_ns, 4 * kMs);
}

TEST(Timeline, ListsRunsOfSporadicModulesOutsideOfRows) {
  Made made;
  auto& thread = made.recording.executors[0].threads[1];
  thread.copy.entries = {
      {100, FlightKind::run, 1, 50}, {300, FlightKind::ready, 1, 0}, {400, FlightKind::run, 1, 90}};
  thread.open.push_back({.module = 2, .doing = channel::Doing::run, .since_ns = 500, .seen_ns = 600});
  const Timeline line = timeline_of(thread, false, 0);
  EXPECT_TRUE(line.rows.empty());
  ASSERT_EQ(line.runs.size(), 3U);
  EXPECT_FALSE(line.runs[2].ended);
  EXPECT_EQ(line.marks.size(), 1U);
}

}  // namespace
}  // namespace takt::flight::timeline_test
