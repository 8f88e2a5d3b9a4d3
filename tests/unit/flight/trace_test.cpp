#include <takt/flight/trace.hpp>

#include <gtest/gtest.h>
#include <full_form.hpp>

#include <map>
#include <random>
#include <vector>

#include <nlohmann/json.hpp>

#include "recordings.hpp"

namespace takt::flight::trace_test {
namespace {

using json = nlohmann::json;
using channel::FlightKind;
constexpr std::int64_t kMs = Made::kMs;
constexpr std::int64_t kUs = Made::kUs;
constexpr std::size_t kPlenty = 1U << 30;

/// Checks that each event has the members that Chrome and Perfetto need, that the events of a thread do not
/// overlap, and that every run lies within a row.
void expect_sound(const json& trace) {
  struct Span {
    double begin, end;
    bool row;
  };
  std::map<int, std::vector<Span>> threads;
  for (const json& event : trace.at("traceEvents")) {
    ASSERT_TRUE(event.at("ph").is_string() && event.at("pid").is_number() && event.at("tid").is_number() &&
                event.at("name").is_string())
        << event;
    const std::string kind = event["ph"];
    if (kind == "M") continue;
    ASSERT_TRUE(event.at("ts").is_number() && event.at("cat").is_string()) << event;
    if (kind == "i") {
      ASSERT_EQ(event.at("s"), "t");
      continue;
    }
    ASSERT_EQ(kind, "X") << event;
    ASSERT_GE(event.at("dur").get<double>(), 0) << event;
    const double begin = event["ts"];
    threads[event["tid"]].push_back({begin, begin + event["dur"].get<double>(), event["cat"] == "row"});
  }
  constexpr double kRounded = 0.002;
  for (const auto& [thread, spans] : threads) {
    double rows_end = -1e18;
    double runs_end = -1e18;
    for (const Span& span : spans) {
      if (span.row) {
        ASSERT_GE(span.begin, rows_end - kRounded) << thread;
        rows_end = span.end;
        runs_end = span.begin;
        continue;
      }
      ASSERT_GE(span.begin, runs_end - kRounded) << thread;
      runs_end = span.end;
      if (thread % 2 == 0 && thread < 1000) {
        ASSERT_LE(span.end, rows_end + kRounded) << thread;
      }
    }
  }
}

std::vector<json> of_category(const json& trace, const std::string& category) {
  std::vector<json> found;
  for (const json& event : trace["traceEvents"]) {
    if (event.value("cat", "") == category) found.push_back(event);
  }
  return found;
}

TEST(Trace, IsValidJsonForAnEmptyRecording) {
  Made made;
  const json trace = json::parse(trace_json(made.recording, kPlenty));
  expect_sound(trace);
  EXPECT_EQ(trace["otherData"]["format"], kTraceFormat);
  EXPECT_EQ(trace["otherData"]["threads"].size(), 2U);
  EXPECT_TRUE(of_category(trace, "row").empty());
}

TEST(Trace, ContainsEveryKindOfEntry) {
  Made made;
  made.recording.modules[1].ports = {"in", "speed"};
  made.good(0, 10);
  made.add(FlightKind::row, 10 * kMs, 0, 0);
  made.add(FlightKind::swapped, 10 * kMs, 1, 0);
  made.add(FlightKind::write, 0, 1, 1);
  made.add(FlightKind::event, 0, 1, 9);
  made.add(FlightKind::run, 10 * kMs + 5 * kUs, 1, 5 * kUs);
  made.add(FlightKind::released, 10 * kMs + 5 * kUs, 2, 3);
  made.add(FlightKind::body, 9 * kMs + 5 * kUs, 2, 700 * kUs);
  made.add(FlightKind::row_end, 10 * kMs + 6 * kUs, 0, 0);
  made.recording.changes.push_back({10 * kMs, 1, "EXECUTING", "RECOVER", "error", "a \"quoted\"\nreason"});
  made.recording.taken_ns = 20 * kMs;
  made.recording.last = std::chrono::milliseconds{20};
  made.recording.t0_ns = -3 * kMs;
  const json trace = json::parse(trace_json(made.recording, kPlenty));
  expect_sound(trace);
  EXPECT_EQ(trace["otherData"]["t0_us"], -3000.0);
  EXPECT_EQ(of_category(trace, "row").size(), 11U);
  EXPECT_EQ(of_category(trace, "run").size(), 21U);
  ASSERT_EQ(of_category(trace, "write").size(), 1U);
  EXPECT_EQ(of_category(trace, "write")[0]["name"], "write m1.speed");
  EXPECT_EQ(of_category(trace, "event")[0]["name"], "event m1.port 9");
  EXPECT_EQ(of_category(trace, "release")[0]["args"]["release"], "dropped: the program is still in its body");
  ASSERT_EQ(of_category(trace, "swap").size(), 1U);
  EXPECT_EQ(of_category(trace, "swap")[0]["name"], "swapped m1");
  EXPECT_DOUBLE_EQ(of_category(trace, "swap")[0]["ts"], 10000);
  EXPECT_EQ(of_category(trace, "body")[0]["name"], "m2");
  EXPECT_DOUBLE_EQ(of_category(trace, "body")[0]["dur"], 700);
  EXPECT_EQ(of_category(trace, "state")[0]["name"], "m1: EXECUTING -> RECOVER");
  EXPECT_EQ(of_category(trace, "state")[0]["args"]["text"], "a \"quoted\"\nreason");
  EXPECT_DOUBLE_EQ(of_category(trace, "row")[1]["ts"], 1000.1);
  EXPECT_DOUBLE_EQ(of_category(trace, "row")[1]["args"]["release_us"], 1000);
}

TEST(Trace, ShowsTheCauseOfEachLateStart) {
  Made made;
  made.good(0, 100);
  made.row(100 * kMs, 100, {{0, 1540 * kUs}, {1, 60 * kUs}});
  made.row(101 * kMs, 640 * kUs, {{0, 40 * kUs}, {1, 60 * kUs}});
  made.good(102, 10);
  const json trace = json::parse(trace_json(made.recording, kPlenty));
  expect_sound(trace);
  std::vector<json> late;
  for (const json& event : trace["traceEvents"]) {
    if (event.contains("args") && event["args"].contains("cause")) late.push_back(event);
  }
  ASSERT_EQ(late.size(), 2U);
  EXPECT_EQ(late[0]["cat"], "run");
  EXPECT_EQ(late[0]["name"], "m1");
  EXPECT_EQ(late[0]["args"]["cause"], "predecessor");
  EXPECT_EQ(late[1]["cat"], "row");
  EXPECT_EQ(late[1]["args"]["cause"], "own overrun");
  EXPECT_EQ(late[1]["args"]["culprit"], "m0");
  EXPECT_DOUBLE_EQ(late[1]["args"]["begins_late_us"], 640);
  EXPECT_EQ(trace["otherData"]["threads"][0]["late"], 2);
}

TEST(Trace, ContainsOnlyTheNewestPartOfALongRecording) {
  Made made;
  made.good(0, 1000);
  made.recording.last = std::chrono::seconds{1};
  const std::string whole = trace_json(made.recording, kPlenty);
  const std::string cut = trace_json(made.recording, whole.size() / 2);
  EXPECT_LE(cut.size(), whole.size() / 2);
  EXPECT_GT(cut.size(), whole.size() / 4);
  const json trace = json::parse(cut);
  expect_sound(trace);
  EXPECT_GT(trace["otherData"]["left_out_us"], 400'000.0);
  const auto rows = of_category(trace, "row");
  EXPECT_NEAR(rows.back()["ts"].get<double>(), trace["otherData"]["lasts_us"].get<double>() - 100, 1);
}

TEST(Trace, ReportsTheNumberOfLostEntries) {
  Made made;
  made.good(0, 3);
  made.recording.executors[0].threads[0].copy.lost = 4;
  made.recording.executors[0].threads[0].copy.written += 10;
  const json trace = json::parse(trace_json(made.recording, kPlenty));
  EXPECT_EQ(trace["otherData"]["lost"], 4);
  EXPECT_EQ(trace["otherData"]["threads"][0]["older"], 6);
}

TEST(Trace, IsValidJsonForAnyContentOfTheRing) {
  std::mt19937 random{3};
  const auto any = [&random](std::int64_t most) {
    return std::uniform_int_distribution<std::int64_t>{0, most}(random);
  };
  const int count = how_often(300);
  for (int turn = 0; turn < count; ++turn) {
    Made made;
    std::int64_t now = 0;
    for (int i = 0; i < 50; ++i) {
      now = std::max(now, i * kMs) + any(10'000);
      made.add(FlightKind::row, now, 0, now - std::min<std::int64_t>(now, i * kMs));
      for (std::int64_t runs = any(4); runs > 0; --runs) {
        const std::int64_t took = any(400'000);
        if (any(3) == 0) made.add(FlightKind::write, now, 1, any(3));
        now += took;
        made.add(FlightKind::run, now, static_cast<std::uint32_t>(any(5)), took);
      }
      if (any(20) != 0) made.add(FlightKind::row_end, now, 0, 0);
    }
    auto& entries = made.recording.executors[0].threads[0].copy.entries;
    entries.erase(entries.begin(), entries.begin() + any(static_cast<std::int64_t>(entries.size())));
    made.recording.executors[0].threads[0].copy.written = entries.size();
    made.recording.taken_ns = now;
    const json trace = json::parse(trace_json(made.recording, kPlenty));
    expect_sound(trace);
    if (testing::Test::HasFatalFailure()) return;
  }
}

}  // namespace
}  // namespace takt::flight::trace_test
