#include "trace_report.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include <nlohmann/json.hpp>

namespace takt::tool {
namespace {

using json = nlohmann::ordered_json;

json trace() {
  json late = {{"release_us", 1000.0},   {"late_us", 640.0},
               {"due_us", 1000.0},       {"begins_late_us", 640.0},
               {"cause", "own overrun"}, {"why", "m0 ran 1.54 ms in the row before"}};
  return {
      {"traceEvents",
       {{{"ph", "M"}, {"pid", 1}, {"tid", 10}, {"name", "thread_name"}, {"args", {{"name", "executor plc"}}}},
        {{"ph", "X"},
         {"pid", 1},
         {"tid", 10},
         {"ts", 0.1},
         {"dur", 5.0},
         {"cat", "row"},
         {"name", "row"},
         {"args", {{"release_us", 0.0}, {"late_us", 0.1}}}},
        {{"ph", "X"},
         {"pid", 1},
         {"tid", 10},
         {"ts", 1640.0},
         {"dur", 5.0},
         {"cat", "row"},
         {"name", "row"},
         {"args", late}},
        {{"ph", "X"},
         {"pid", 1},
         {"tid", 10},
         {"ts", 1640.0},
         {"dur", 5.0},
         {"cat", "run"},
         {"name", "m1"},
         {"args",
          {{"due_us", 1600.0}, {"begins_late_us", 40.0}, {"cause", "wake-up"}, {"why", "woken late"}}}},
        {{"ph", "i"},
         {"s", "t"},
         {"pid", 1},
         {"tid", 1},
         {"ts", 3.0},
         {"cat", "state"},
         {"name", "m0: START -> EXECUTING"}}}},
      {"otherData",
       {{"format", "takt trace 1"},
        {"cell", "belt"},
        {"device", "line"},
        {"machine", "pc"},
        {"kernel", "6.1"},
        {"why", "asked for"},
        {"taken_utc_ns", 1'700'000'000'000'000'000},
        {"lasts_us", 5e6},
        {"lost", 0},
        {"threads",
         {{{"name", "executor plc"},
           {"thread", 10},
           {"executor", "plc"},
           {"rows", 2},
           {"runs", 1},
           {"late", 2},
           {"lost", 0},
           {"holds_us", 4e6},
           {"basic_period_us", 1000.0},
           {"late_beyond_us", 20.0}}}}}}};
}

TEST(TraceReport, HasTheWorstFirst) {
  const auto summary = summary_of(trace());
  ASSERT_TRUE(summary.ok()) << to_text(summary.problems());
  ASSERT_EQ(summary->late.size(), 2U);
  EXPECT_EQ(summary->late[0].what, "plc");
  EXPECT_EQ(summary->late[0].late_us, 640);
  EXPECT_EQ(summary->late[1].what, "plc.m1");
  ASSERT_EQ(summary->executors.size(), 1U);
  EXPECT_EQ(summary->executors[0].rows, 2U);
  EXPECT_EQ(summary->changes.at("m0: START -> EXECUTING"), 1U);
}

TEST(TraceReport, SaysEachCauseWithItsNumbers) {
  const json report = trace_json_report(*summary_of(trace()));
  EXPECT_EQ(report["late_starts"], 2);
  EXPECT_EQ(report["causes"].size(), 2U);
  EXPECT_EQ(report["causes"]["own overrun"]["count"], 1);
  EXPECT_EQ(report["causes"]["own overrun"]["max_us"], 640.0);
  EXPECT_EQ(report["worst"][0]["why"], "m0 ran 1.54 ms in the row before");
}

TEST(TraceReport, KeepsToTheWidth) {
  auto summary = *summary_of(trace());
  for (int i = 0; i < 30; ++i)
    summary.late.push_back(
        {"an_executor_with_a_long_name.and_a_module_with_a_long_one", 1e6, 12.5 + i, "preemption",
         std::string(30, 'x') + " waited 1.50 ms for a processor; gave way 3 times; 812 page faults"});
  summary.lost = 7;
  summary.left_out_us = 2e6;
  const std::string text = trace_report(summary, {.colour = false, .width = 80});
  std::istringstream lines{text};
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80U) << line;
  EXPECT_NE(text.find("The worst 10 of 32:"), std::string::npos) << text;
  EXPECT_NE(text.find("own overrun"), std::string::npos);
}

TEST(TraceReport, SaysThatNothingWasLate) {
  auto summary = *summary_of(trace());
  summary.late.clear();
  EXPECT_NE(trace_report(summary, {}).find("Nothing began late."), std::string::npos);
}

TEST(TraceReport, WhatIsNoTraceIsRefused) {
  for (const json& none : {json{}, json::object(), json::array(), json{{"otherData", {{"format", "other"}}}},
                           json{{"otherData", 5}}, json{{"traceEvents", json::array()}}}) {
    const auto summary = summary_of(none);
    ASSERT_FALSE(summary.ok()) << none;
    EXPECT_EQ(summary.problems()[0].what, "it is no trace of takt");
  }
}

// Whatever member is missing or of another kind: a reason, and no crash.
TEST(TraceReport, ADamagedTraceIsRefused) {
  const json whole = trace();
  for (const auto& [key, value] : whole["otherData"].items()) {
    json damaged = whole;
    damaged["otherData"].erase(key);
    const auto summary = summary_of(damaged);
    EXPECT_FALSE(summary.ok()) << key;
    damaged = whole;
    damaged["otherData"][key] = json::array({1, 2});
    EXPECT_FALSE(summary_of(damaged).ok()) << key;
  }
  for (const json& events : {json{1, 2}, json::object({{"a", 1}}), json(7)}) {
    json damaged = whole;
    damaged["traceEvents"] = events;
    static_cast<void>(summary_of(damaged));
  }
}

}  // namespace
}  // namespace takt::tool
