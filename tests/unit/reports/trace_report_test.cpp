#include "reports/trace_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

#include "pictures.hpp"

namespace takt::tool::trace_report_test {
namespace {

using json = nlohmann::ordered_json;

json trace() {
  json late = {{"release_us", 1000.0},   {"late_us", 640.0},
               {"due_us", 1000.0},       {"begins_late_us", 640.0},
               {"cause", "own overrun"}, {"why", "m0 ran 1.54 ms in the previous row"}};
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

TEST(TraceReport, ListsTheMostDelayedStartsFirst) {
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

TEST(TraceReport, CountsTheLateStartsOfEachCause) {
  const json report = trace_json_report(*summary_of(trace()));
  EXPECT_EQ(report["late_starts"], 2);
  EXPECT_EQ(report["causes"].size(), 2U);
  EXPECT_EQ(report["causes"]["own overrun"]["count"], 1);
  EXPECT_EQ(report["causes"]["own overrun"]["max_us"], 640.0);
  EXPECT_EQ(report["worst"][0]["why"], "m0 ran 1.54 ms in the previous row");
}

TEST(TraceReport, NeverExceedsTheWidthOfTheTerminal) {
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

TEST(TraceReport, SaysIfNothingWasLate) {
  auto summary = *summary_of(trace());
  summary.late.clear();
  EXPECT_NE(trace_report(summary, {}).find("No row and no module began late."), std::string::npos);
}

TEST(TraceReport, RejectsAFileThatIsNotATrace) {
  for (const json& none : {json{}, json::object(), json::array(), json{{"otherData", {{"format", "other"}}}},
                           json{{"otherData", 5}}, json{{"traceEvents", json::array()}}}) {
    const auto summary = summary_of(none);
    ASSERT_FALSE(summary.ok()) << none;
    EXPECT_EQ(summary.problems()[0].what, "is not a Takt trace");
  }
}

// The report rejects a trace in which a member of "otherData" is missing or has the wrong type.
TEST(TraceReport, RejectsADamagedTrace) {
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

json of_thread(int thread, const char* category, const std::string& name, double at_us, double took_us) {
  return {{"ph", "X"}, {"tid", thread}, {"ts", at_us}, {"dur", took_us}, {"cat", category}, {"name", name}};
}

/// Returns the left edge and the width of each bar that has the class `look`.
std::vector<std::pair<double, double>> bars(const std::string& drawing, const std::string& look) {
  std::vector<std::pair<double, double>> found;
  const std::regex bar{R"re(<rect x="([0-9.]+)" y="[0-9.]+" width="([0-9.]+)"[^>]* class=")re" + look + "\""};
  for (std::sregex_iterator at{drawing.begin(), drawing.end(), bar}; at != std::sregex_iterator{}; ++at)
    found.emplace_back(std::stod((*at)[1]), std::stod((*at)[2]));
  return found;
}

TEST(TraceSvg, HasALaneForEachModuleThatRan) {
  json whole = trace();
  whole["otherData"]["lasts_us"] = 9000.0;
  whole["traceEvents"].push_back(of_thread(10, "run", "m0", 4500, 900));
  whole["traceEvents"].push_back(of_thread(100'000, "body", "vision", 3000, 4500));
  const auto drawing = trace_svg(whole);
  ASSERT_TRUE(drawing);
  drawings::expect_readable(*drawing);
  for (const char* word :
       {">executor plc<", ">rows<", ">m0<", ">m1<", ">programs<", ">vision<", ">time in ms<"})
    EXPECT_THAT(*drawing, testing::HasSubstr(word));
  EXPECT_THAT(*drawing, testing::Not(testing::HasSubstr(">-0<")));
  const auto program = bars(*drawing, "process");
  ASSERT_EQ(program.size(), 1U);
  EXPECT_NEAR(program[0].second, 450, 1) << "half of 9 ms";
  const auto threads = bars(*drawing, "thread");
  ASSERT_EQ(threads.size(), 2U);
  EXPECT_NEAR(threads[1].first - program[0].first, 150, 1) << "1.5 ms later";
  EXPECT_NEAR(threads[1].second, 90, 1);
}

TEST(TraceSvg, MarksLateStartsWithTheirReason) {
  const auto drawing = trace_svg(trace());
  ASSERT_TRUE(drawing);
  EXPECT_THAT(*drawing,
              testing::HasSubstr("<title>rows: 640 us late: m0 ran 1.54 ms in the previous row</title>"));
  EXPECT_THAT(*drawing, testing::HasSubstr("began late: 2 starts"));
  EXPECT_THAT(*drawing, testing::HasSubstr("plc.m1, 40 us late: wake-up; woken late"));
  json quiet = trace();
  for (json& event : quiet["traceEvents"]) {
    if (!event.contains("args")) continue;
    for (const char* member : {"begins_late_us", "cause", "why", "due_us"}) event["args"].erase(member);
  }
  const auto none = trace_svg(quiet);
  ASSERT_TRUE(none);
  EXPECT_THAT(*none, testing::HasSubstr("No row and no module began late."));
}

TEST(TraceSvg, DrawsNoLineThroughATitle) {
  json whole = trace();
  whole["traceEvents"][0]["args"]["name"] = "executor of a name longer than those of its modules";
  const auto drawing = trace_svg(whole);
  ASSERT_TRUE(drawing);
  const auto labels = drawings::labels(*drawing);
  const auto title = std::find_if(labels.begin(), labels.end(),
                                  [](const auto& l) { return l.words.starts_with("executor "); });
  ASSERT_NE(title, labels.end());
  const std::regex line{R"re(<line x1="([0-9.]+)" y1="([0-9.]+)" x2="[0-9.]+" y2="([0-9.]+)")re"};
  std::size_t lines = 0;
  for (std::sregex_iterator at{drawing->begin(), drawing->end(), line}, end; at != end; ++at, ++lines)
    EXPECT_FALSE(std::stod((*at)[2]) < title->baseline && std::stod((*at)[3]) > title->baseline) << at->str();
  EXPECT_GT(lines, 0U);
}

TEST(TraceSvg, SaysIfNothingRan) {
  json whole = trace();
  whole["traceEvents"] = json::array();
  const auto drawing = trace_svg(whole);
  ASSERT_TRUE(drawing);
  EXPECT_THAT(*drawing, testing::HasSubstr(">no module ran in this time<"));
  drawings::expect_readable(*drawing);
}

TEST(TraceSvg, ShowsTheNewestPartOfALongTrace) {
  json whole = trace();
  for (std::size_t i = 0; i < kTraceBars; ++i)
    whole["traceEvents"].push_back(of_thread(10, "run", "m2", 4e6 + static_cast<double>(i) * 200, 50));
  const auto drawing = trace_svg(whole);
  ASSERT_TRUE(drawing);
  EXPECT_THAT(*drawing, testing::HasSubstr("1 s, the end of a trace of 5 s"));
  EXPECT_THAT(*drawing, testing::HasSubstr("at 1 ms (not drawn): plc, 640 us late"));
  EXPECT_EQ(bars(*drawing, "thread").size(), kTraceBars);
  EXPECT_TRUE(bars(*drawing, "row").empty()) << "the rows are older";
}

TEST(TraceSvg, RejectsAFileThatIsNotATrace) {
  for (json none : {json{}, json::array(), json{{"otherData", 5}}}) EXPECT_FALSE(trace_svg(none));
  json damaged = trace();
  damaged["traceEvents"][1].erase("dur");
  EXPECT_FALSE(trace_svg(damaged));
}

}  // namespace
}  // namespace takt::tool::trace_report_test
