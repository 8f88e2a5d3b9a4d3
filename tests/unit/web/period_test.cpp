#include "web/period.hpp"

#include <gmock/gmock.h>

#include <takt/model/json.hpp>

#include "seen.hpp"
#include "web/samples_json.hpp"

namespace takt::tool::web::period_test {
namespace {

using namespace seen;

constexpr double kMs = 1000;  // one millisecond in us, the time unit of traces

/// The trace of a robot. The grid of 1 ms began 0.4 ms before the trace. The macro periods of 3 ms begin at
/// 2.6 ms, 5.6 ms and so on in the trace.
class Traced {
 public:
  void row(double release, double late, std::vector<std::pair<std::string, double>> runs,
           Json args = Json::object()) {
    double at = release + late;
    double took = 1;
    for (const auto& [module, run] : runs) took += run;
    args.update(Json{{"release_us", release}, {"late_us", late}});
    events.push_back({{"ph", "X"}, {"tid", 10}, {"ts", at}, {"dur", took}, {"cat", "row"}, {"args", args}});
    for (const auto& [module, run] : runs) {
      add(10, "run", module, at, run);
      at += run;
    }
  }
  void add(int thread, const char* category, const std::string& name, double at, double took,
           Json args = nullptr) {
    Json event{{"ph", "X"}, {"tid", thread}, {"ts", at}, {"dur", took}, {"cat", category}, {"name", name}};
    if (!args.is_null()) event["args"] = args;
    events.push_back(std::move(event));
  }
  [[nodiscard]] Json json(double lasts) const {
    Json trace{{"traceEvents", events},
               {"otherData",
                {{"begins_utc_ns", 1'000'000'000},
                 {"lasts_us", lasts},
                 {"threads",
                  {{{"executor", "main"}, {"thread", 10}, {"basic_period_us", 1000.0}},
                   {{"executor", "main"}, {"thread", 11}}}}}}};
    if (t0_us) trace["otherData"]["t0_us"] = *t0_us;
    return trace;
  }

  Json events = Json::array();
  std::optional<double> t0_us = -0.4 * kMs;
};

Result<Json> period(const Traced& traced, double lasts) {
  const model::Cell press = cell();
  return period_json(traced.json(lasts), press, press.devices[0]);
}

TEST(MacroPeriod, IsTheLastCompleteOneInTheTrace) {
  Traced traced;
  for (int i = 0; i < 11; ++i) {
    traced.row((i + 0.6) * kMs, 10.5, {{"servo", 20}});
  }
  const auto json = period(traced, 11 * kMs);  // 11 ms is within the period that begins at 8.6 ms
  ASSERT_TRUE(json);
  const Json& main = (*json)["executors"][0];
  EXPECT_EQ(main["name"], "main");
  EXPECT_EQ(main["macro_period_ns"], 3'000'000);
  EXPECT_EQ(main["begin_ms"], 1000 + 5.6);
  ASSERT_EQ(main["rows"].size(), 3U);
  EXPECT_EQ(
      main["rows"][0].dump(),
      R"({"row":0,"due_ns":0,"begin_ns":10500,"end_ns":31500,"runs":[{"module":"servo","begin_ns":10500,"end_ns":30500}]})");
  EXPECT_EQ(main["rows"][2]["row"], 2);
  EXPECT_EQ(main["rows"][2]["due_ns"], 2'000'000);
}

TEST(MacroPeriod, OmitsMissedRows) {
  Traced traced;
  traced.row(2.6 * kMs, 5, {});
  traced.row(4.6 * kMs, 5, {});
  const auto json = period(traced, 6 * kMs);
  ASSERT_TRUE(json);
  const Json& rows = (*json)["executors"][0]["rows"];
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0]["row"], 0);
  EXPECT_EQ(rows[1]["row"], 2);
}

TEST(MacroPeriod, ShowsWhyARowOrRunIsLate) {
  Traced traced;
  traced.row(2.6 * kMs, 300, {}, {{"why", "the hypervisor had the processor"}});
  traced.add(10, "run", "slow", 2.9 * kMs, 0.5, {{"begins_late_us", 250.0}, {"why", "servo took 250 us"}});
  const auto json = period(traced, 6 * kMs);
  ASSERT_TRUE(json);
  const Json& row = (*json)["executors"][0]["rows"][0];
  EXPECT_EQ(row["cause"], "the hypervisor had the processor");
  EXPECT_EQ(row["runs"][0]["late_ns"], 250'000);
  EXPECT_EQ(row["runs"][0]["cause"], "servo took 250 us");
}

TEST(MacroPeriod, ListsSporadicRunsInTheRowDuringWhichTheyBegan) {
  Traced traced;
  traced.row(2.6 * kMs, 5, {{"servo", 10}});
  traced.row(3.6 * kMs, 5, {{"servo", 10}});
  traced.add(11, "run", "react", 3.9 * kMs, 50);
  traced.add(11, "run", "react", 1.9 * kMs, 50);  // begins before the macro period
  const auto json = period(traced, 6 * kMs);
  ASSERT_TRUE(json);
  const Json& rows = (*json)["executors"][0]["rows"];
  EXPECT_EQ(rows[0]["runs"].size(), 1U);
  ASSERT_EQ(rows[1]["runs"].size(), 2U);
  EXPECT_EQ(rows[1]["runs"][1].dump(),
            R"({"module":"react","begin_ns":1300000,"end_ns":1350000,"sporadic":true})");
}

TEST(MacroPeriod, IncludesProgramRunsThatBeganWithinIt) {
  Traced traced;
  traced.row(2.6 * kMs, 5, {});
  traced.add(100'000, "body", "vision", 3 * kMs, 700);
  traced.add(100'000, "body", "vision", 1 * kMs, 700);
  const auto json = period(traced, 6 * kMs);
  ASSERT_TRUE(json);
  EXPECT_EQ((*json)["programs"].dump(), R"([{"module":"vision","begin_ns":400000,"end_ns":1100000}])");
}

TEST(MacroPeriod, IsReportedAsMissingIfNoneIsComplete) {
  Traced traced;
  traced.row(0.6 * kMs, 5, {});
  auto json = period(traced, 5 * kMs);  // the period that ends at 2.6 ms began before the trace
  ASSERT_TRUE(json);
  EXPECT_TRUE((*json)["executors"][0]["rows"].empty());
  EXPECT_EQ((*json)["executors"][0]["text"], "the trace has no complete macro period");
  traced.t0_us = 2 * kMs;
  json = period(traced, 4 * kMs);  // no macro period has ended since T0
  ASSERT_TRUE(json);
  EXPECT_TRUE((*json)["executors"][0]["rows"].empty());
}

TEST(MacroPeriod, DoesNotExistBeforeTheFirstRow) {
  Traced traced;
  traced.t0_us.reset();
  const auto json = period(traced, 5 * kMs);
  ASSERT_FALSE(json);
  EXPECT_EQ(json.problems()[0].what, "device robot has not run a row of its table yet");
}

TEST(MacroPeriod, CannotBeReadFromAFileThatIsNotATrace) {
  const model::Cell press = cell();
  for (const char* text :
       {"{}", "[]", "5", "nonsense", R"({"otherData": {"t0_us": 5}})",
        R"({"otherData": {"t0_us": 0, "lasts_us": 9, "begins_utc_ns": 0, "threads": [5]}})",
        R"({"otherData": {"t0_us": "a", "lasts_us": 9, "begins_utc_ns": 0, "threads": []}})"})
    EXPECT_FALSE(period_json(model::parse_json(text), press, press.devices[0])) << text;
}

TEST(MacroPeriod, NeedsATraceOfTwoMacroPeriodsButAtMostTenSeconds) {
  const model::Cell press = cell();
  EXPECT_EQ(trace_needed(press, press.devices[0]), std::chrono::milliseconds{56});
  model::Cell slow = press;
  slow.devices[0].modules[1].period = std::chrono::seconds{60};
  slow.devices[0].modules[0].period = std::chrono::seconds{1};
  EXPECT_EQ(trace_needed(slow, slow.devices[0]), std::chrono::seconds{10});
}

}  // namespace
}  // namespace takt::tool::web::period_test
