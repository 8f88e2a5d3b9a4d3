#include "web/value_history.hpp"

#include <algorithm>
#include <cmath>

#include <gmock/gmock.h>

namespace takt::tool::web::value_history_test {
namespace {

using namespace std::chrono_literals;
using testing::DoubleEq;
using testing::ElementsAre;
using testing::NanSensitiveDoubleEq;

constexpr std::int64_t kBegin_ns = 1'700'000'000'000'000'000;

std::int64_t at(Nanoseconds since) { return kBegin_ns + since.count(); }

std::vector<double> values(const ValueHistory& history, std::size_t field = 0) {
  std::vector<double> found;
  for (const auto* row : history.after(0, SIZE_MAX)) found.push_back(row->values[field]);
  return found;
}

TEST(ValueHistory, KeepsEachValueOfASlowPort) {
  ValueHistory history;
  for (int i = 0; i < 5; ++i) history.add(at(i * 20ms), {static_cast<double>(i)});
  EXPECT_THAT(values(history), ElementsAre(0, 1, 2, 3)) << "the interval of the last value is still open";
  history.complete();
  EXPECT_THAT(values(history), ElementsAre(0, 1, 2, 3, 4));
}

TEST(ValueHistory, KeepsTheExtremesOfEachFieldInTheirOrder) {
  ValueHistory history;
  history.add(at(0ms), {5, 1});
  history.add(at(4ms), {9, NAN});
  history.add(at(8ms), {2, 3});
  history.add(at(12ms), {4, INFINITY});
  history.complete();
  EXPECT_THAT(values(history, 0), ElementsAre(9, 2));
  EXPECT_THAT(values(history, 1), ElementsAre(1, 3));
}

TEST(ValueHistory, MarksMissingValuesAsNotANumber) {
  ValueHistory history;
  history.add(at(0ms), {INFINITY});
  history.complete();
  EXPECT_THAT(values(history), ElementsAre(NanSensitiveDoubleEq(NAN)));
}

TEST(ValueHistory, ForgetsTheValuesFromBeforeATime) {
  ValueHistory history;
  for (int i = 0; i < 3600; ++i) history.add(at(i * 1s), {static_cast<double>(i)});
  history.complete();
  history.forget(at(3597s));
  EXPECT_THAT(values(history), ElementsAre(3597, 3598, 3599));
}

TEST(ValueHistory, KeepsAPeakOfOneSampleForHours) {
  ValueHistory history;
  std::size_t largest = 0;
  // Ten hours at 100 Hz, with a peak of one sample in each minute.
  for (std::int64_t i = 0; i < 10LL * 3600 * 100; ++i) {
    const bool peak = i % 6000 == 3017;
    history.add(at(i * 10ms),
                {peak ? 100.0 + static_cast<double>(i / 6000) : std::sin(static_cast<double>(i) / 7)});
    if (i % 60000 == 0) largest = std::max(largest, history.after(0, SIZE_MAX).size());
  }
  const auto rows = history.after(0, SIZE_MAX);
  for (int minute = 10 * 60 - 4 * 60 + 1; minute < 10 * 60; ++minute) {
    EXPECT_EQ(1, std::count_if(rows.begin(), rows.end(),
                               [&](const auto* row) { return row->values[0] == 100.0 + minute; }))
        << "minute " << minute;
  }
  EXPECT_TRUE(std::is_sorted(rows.begin(), rows.end(),
                             [](const auto* a, const auto* b) { return a->time_ns < b->time_ns; }));
  EXPECT_LE(largest, 60'000U) << "memory must be bounded";
  EXPECT_GE(rows.front()->time_ns, at(10h - 4h - 2s));
  EXPECT_LE(rows.front()->time_ns, at(10h - 4h + 2s));
}

TEST(ValueHistory, ReturnsEachValueOnceInPartsWhileItThinsOlderValues) {
  ValueHistory history;
  std::int64_t i = 0;
  const auto go_on = [&](int samples) {
    for (const std::int64_t end = i + samples; i < end; ++i)
      history.add(at(i * 20ms), {i % 5000 == 77 ? 1.0 + static_cast<double>(i) : 0.0});
  };
  go_on(50 * 60 * 20);  // 20 minutes
  std::vector<double> peaks;
  std::int64_t last = 0;
  for (int part = 0; part < 200; ++part) {
    for (const auto* row : history.after(last, 100)) {
      EXPECT_GT(row->time_ns, last);
      last = row->time_ns;
      if (row->values[0] > 0) peaks.push_back(row->values[0]);
    }
    go_on(500);  // the history thins 10 s of old values before the next part
  }
  std::vector<double> expected;
  for (std::int64_t k = 77; k < 50 * 60 * 20; k += 5000) expected.push_back(1.0 + static_cast<double>(k));
  peaks.resize(std::min(peaks.size(), expected.size()));
  EXPECT_EQ(expected, peaks);
}

TEST(ValueHistory, BeginsAnewIfTheClockIsSetBack) {
  ValueHistory history;
  history.add(at(1h), {1});
  history.add(at(1h - 1ms), {2});  // arrived out of order
  history.complete();
  EXPECT_THAT(values(history), ElementsAre(1, 2));
  history.add(at(0ms), {3});
  history.complete();
  EXPECT_THAT(values(history), ElementsAre(3));
  EXPECT_EQ(history.newest(), at(0ms));
}

}  // namespace
}  // namespace takt::tool::web::value_history_test
