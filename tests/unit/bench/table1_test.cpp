#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>

#include <unistd.h>

#include <takt/descriptor/descriptor.hpp>

#include "jitter_chart.hpp"
#include "table1_cases.hpp"
#include "table1_page.hpp"
#include "table1_report.hpp"
#include "table1_result.hpp"

#include "../reports/pictures.hpp"

namespace takt::bench::table1_test {
namespace {

using namespace std::chrono_literals;
using model::ModuleType;
using model::Operation;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

// ---- Cases

TEST(Table1Cases, MatchTheTableOfThePaper) {
  ASSERT_EQ(10U, kTable1.size());
  int number = 0;
  for (const Table1Case& one : kTable1) EXPECT_EQ(++number, one.number);
  const Table1Case& last = kTable1.back();
  EXPECT_EQ(5, last.so);
  EXPECT_EQ(3, last.exe);
  EXPECT_EQ(5, last.sporadic_so);
  EXPECT_EQ(5, last.sporadic_exe);
  EXPECT_EQ(8, last.non_real);
  EXPECT_EQ(ModuleType::process, last.measured);
  EXPECT_EQ(11.758, last.paper.worst);
  EXPECT_EQ(9, last.cpus_wanted());
  EXPECT_EQ(15, kTable1[1].so);
}

TEST(Table1Cases, HaveDescriptorsWithTheModulesOfThePaper) {
  for (const Table1Case& one : kTable1) {
    const std::string text = descriptor_of(
        one, {.period = 100us, .cpu = 3, .priority = 70, .file = "/tmp/a & b", .releases = 500});
    const auto cell = descriptor::parse(text, "case.xml");
    ASSERT_TRUE(cell.ok()) << to_text(cell.problems()) << text;
    const model::Device& device = cell->devices.at(0);
    std::map<std::pair<Operation, ModuleType>, int> count;
    int recording = 0;
    for (const model::Module& module : device.modules) {
      ++count[{module.operation, module.type}];
      if (module.operation == Operation::periodic) {
        EXPECT_EQ(100us, *module.period);
      }
      if (module.name != "measured") continue;
      ++recording;
      EXPECT_EQ(one.measured, module.type);
      EXPECT_EQ(1, module.priority);
      EXPECT_EQ("/tmp/a & b", *model::given_property(module, "file"));
      EXPECT_EQ("500", *model::given_property(module, "releases"));
    }
    EXPECT_EQ(1, recording);
    EXPECT_EQ(one.so, (count[{Operation::periodic, ModuleType::thread}]));
    EXPECT_EQ(one.exe, (count[{Operation::periodic, ModuleType::process}]));
    EXPECT_EQ(one.sporadic_so, (count[{Operation::sporadic, ModuleType::thread}]));
    EXPECT_EQ(one.sporadic_exe, (count[{Operation::sporadic, ModuleType::process}]));
    EXPECT_EQ(one.non_real, (count[{Operation::non_real, ModuleType::process}]));
    EXPECT_EQ(3, *device.executors.at(0).cpu);
    EXPECT_EQ(70, device.executors.at(0).priority);
  }
}

// ---- Verdicts

CaseResult result_of(std::size_t place, double p50_ns, double p99_ns, double bare_p99_ns) {
  CaseResult result;
  result.one = kTable1.at(place);
  result.takt = {.count = 100, .p50 = p50_ns, .p99 = p99_ns};
  result.loop = {.count = 100, .p99 = bare_p99_ns};
  result.real_time = true;
  result.loop_real_time = true;
  return result;
}

TEST(Table1Verdict, DependsOnTheMedianAndTheP99ForAThreadModule) {
  EXPECT_EQ(Verdict::held, judge(result_of(0, 100, 5000, 10'000), 100us, 1).verdict);
  const Judgement late = judge(result_of(0, 101, 5000, 10'000), 100us, 1);
  EXPECT_EQ(Verdict::not_held, late.verdict);
  EXPECT_THAT(late.why, HasSubstr("p50 0.10 us is more than 0.10 us"));
  const Judgement spread = judge(result_of(0, 50, 5001, 10'000), 100us, 1);
  EXPECT_EQ(Verdict::not_held, spread.verdict);
  EXPECT_THAT(spread.why, HasSubstr("half the bare loop's"));
}

TEST(Table1Verdict, RequiresAP99OfAtMostOneMicrosecondIfThePeriodIsAtLeastOneMillisecond) {
  EXPECT_EQ(Verdict::held, judge(result_of(0, 50, 1001, 10'000), 999us, 1).verdict);
  EXPECT_EQ(Verdict::held, judge(result_of(0, 50, 1000, 10'000), 1ms, 1).verdict);
  EXPECT_EQ(Verdict::not_held, judge(result_of(0, 50, 1001, 10'000), 1ms, 1).verdict);
}

TEST(Table1Verdict, DependsOnlyOnTheMedianForAProcessModule) {
  EXPECT_EQ(Verdict::held, judge(result_of(3, 1000, 90'000, 10), 100us, 4).verdict);
  EXPECT_EQ(Verdict::not_held, judge(result_of(3, 1001, 0, 10), 100us, 4).verdict);
}

TEST(Table1Verdict, SaysIfTheMachineHasTooFewCpus) {
  const Judgement crowded = judge(result_of(3, 1001, 0, 10), 100us, 3);
  EXPECT_EQ(Verdict::more_modules, crowded.verdict);
  EXPECT_THAT(crowded.why, HasSubstr("the case needs 4 CPUs and the machine has 3"));
  EXPECT_EQ(Verdict::held, judge(result_of(3, 1000, 0, 10), 100us, 2).verdict);
}

TEST(Table1Verdict, FailsWithoutSamplesOrRealTimePriority) {
  CaseResult nothing = result_of(0, 0, 0, 10'000);
  nothing.takt.count = 0;
  EXPECT_EQ(Verdict::not_held, judge(nothing, 100us, 4).verdict);
  CaseResult ordinary = result_of(0, 0, 0, 10'000);
  ordinary.real_time = false;
  EXPECT_THAT(judge(ordinary, 100us, 4).why, HasSubstr("denied real-time"));
  CaseResult alone = result_of(0, 0, 0, 10'000);
  alone.loop_real_time = false;
  EXPECT_THAT(judge(alone, 100us, 4).why, HasSubstr("denied the bare loop"));
}

// ---- Reports

Table1Result all_cases() {
  Table1Result result{.machine = {},
                      .wall_ns = 1'795'284'900'000'000'000,
                      .period = 100us,
                      .seconds = 0.5,
                      .cpu = 1,
                      .priority = 80,
                      .cpus = 2,
                      .load = "",
                      .cases = {}};
  result.machine.name = "lab<1>";
  for (std::size_t i = 0; i < kTable1.size(); ++i) {
    CaseResult one = result_of(i, 20, 900, 40'000);
    for (std::int64_t n = 0; n < 2000; ++n) one.jitter.push_back({n + (n > 1500 ? 900 : 0), -(n % 97) * 10});
    one.bare.assign(500, -15'000);
    one.missed = 900;
    result.cases.push_back(one);
  }
  result.cases.back().jitter.clear();  // the last case has no recorded jitter
  result.cases.back().takt = {};
  return result;
}

TEST(Table1Report, ComparesTaktWithThePaperAndABareLoop) {
  const Table1Result result = all_cases();
  const std::string rows = table1_rows(result.cases[0], result);
  EXPECT_THAT(rows, ContainsRegex("1 +1 +0 +0 +0 +0 thread +takt .* 0.02 +0.90 .*900"));
  EXPECT_THAT(rows, ContainsRegex("paper +-0.027 +0.000839 +3.772\n"));
  EXPECT_THAT(rows, ContainsRegex("bare .* 40.0 "));
  EXPECT_THAT(rows, HasSubstr("held\n"));
  EXPECT_THAT(table1_rows(result.cases[9], result),
              HasSubstr("more modules than cores: no release was recorded"));
}

TEST(Table1Report, ContainsEachCaseAsJson) {
  const auto json = table1_json(all_cases());
  ASSERT_EQ(10U, json["cases"].size());
  EXPECT_EQ(100, json["period_us"]);
  EXPECT_EQ(0.02, json["cases"][0]["jitter_us"]["p50"]);
  EXPECT_EQ(40, json["cases"][0]["bare_us"]["p99"]);
  EXPECT_EQ(3.772, json["cases"][0]["paper_us"]["worst"]);
  EXPECT_EQ("held", json["cases"][0]["verdict"]);
  EXPECT_EQ("more modules than cores", json["cases"][9]["verdict"]);
}

bool is_well_formed(const std::string& page) {
  const auto file =
      std::filesystem::path{testing::TempDir()} / ("takt_page_" + std::to_string(::getpid()) + ".html");
  std::ofstream{file} << page;
  const bool right = std::system(("xmllint --noout " + file.string()).c_str()) == 0;
  std::filesystem::remove(file);
  return right;
}

TEST(Table1Page, IsWellFormedWithoutExternalReferences) {
  const std::string page = table1_page(all_cases());
  EXPECT_TRUE(is_well_formed(page));
  for (const char* word : {"http", "//", "src=", "<script", "@import", "url("})
    EXPECT_THAT(page, Not(HasSubstr(word)));
  EXPECT_THAT(page, HasSubstr("lab&lt;1&gt;"));
}

TEST(Table1Page, HasTwoChartsForEachCase) {
  const std::string page = table1_page(all_cases());
  std::size_t charts = 0;
  for (std::size_t at = page.find("<svg "); at != std::string::npos; at = page.find("<svg ", at + 1))
    ++charts;
  EXPECT_EQ(20U, charts);
  for (const Table1Case& one : kTable1)
    EXPECT_THAT(page, HasSubstr("<h2 id=\"case" + std::to_string(one.number) + "\">"));
  EXPECT_THAT(page, HasSubstr("no release was recorded"));
}

TEST(Table1Page, IsWellFormedWithoutCases) {
  Table1Result none = all_cases();
  none.cases.clear();
  EXPECT_TRUE(is_well_formed(table1_page(none)));
}

TEST(JitterOverTime, HasAGapWhereNothingWasReleased) {
  std::vector<Served> served;
  for (std::int64_t n = 0; n < 1000; ++n) served.push_back({n, -100});
  const auto count_medians = [](const std::string& chart) {
    std::size_t count = 0;
    for (std::size_t at = chart.find("\"median\""); at != std::string::npos;
         at = chart.find("\"median\"", at + 1))
      ++count;
    return count;
  };
  EXPECT_EQ(1U + 1U, count_medians(jitter_over_time("t", served, 100us))) << "plus one in the legend";
  for (std::int64_t n = 3000; n < 4000; ++n) served.push_back({n, -100});
  EXPECT_EQ(2U + 1U, count_medians(jitter_over_time("t", served, 100us)));
}

TEST(JitterOverTime, IsDrawnEvenForAFewValues) {
  const std::string one = jitter_over_time("t", {{7, -100}}, 100us);
  EXPECT_THAT(one, AllOf(HasSubstr("class=\"alone\""), Not(HasSubstr("nan"))));
  std::vector<Served> served;
  for (std::int64_t n = 0; n < 20; ++n) served.push_back({n, -100});
  const std::string few = jitter_over_time("t", served, 100us);
  EXPECT_THAT(few, Not(HasSubstr("class=\"alone\"")));
  EXPECT_THAT(few, ContainsRegex("<path d=\"M[^\"]*L[^\"]*L[^\"]*\" class=\"median\"")) << "joined";
}

TEST(JitterCharts, HaveALegendAndAxisTitles) {
  std::vector<Served> served;
  for (std::int64_t n = 0; n < 1000; ++n) served.push_back({n, -100 * n});
  const std::string over_time = jitter_over_time("Case 10: size of the jitter", served, 100us);
  tool::drawings::expect_readable(over_time);
  EXPECT_THAT(over_time,
              AllOf(HasSubstr(">minimum to maximum<"), HasSubstr(">median<"), HasSubstr(">time<")));
  const std::string shares = jitter_histogram("Case 10: share of releases", served, {50'000, 60'000});
  tool::drawings::expect_readable(shares);
  EXPECT_THAT(shares,
              AllOf(HasSubstr(">takt<"), HasSubstr(">the bare loop<"), HasSubstr(">absolute jitter<")));
  EXPECT_THAT(jitter_histogram("t", served, {}), Not(HasSubstr("bare loop")));
}

TEST(HistogramBuckets, DivideEachDecadeIntoTen) {
  EXPECT_EQ((std::vector<std::size_t>{2}), classes_of({0, -9}));
  EXPECT_EQ((std::vector<std::size_t>{0, 1}), classes_of({10}));
  const auto classes = classes_of({-100, 99, 1000});
  ASSERT_EQ(22U, classes.size());
  EXPECT_EQ(1U, classes[10]);
  EXPECT_EQ(1U, classes[11]);
  EXPECT_EQ(1U, classes[21]);
}

}  // namespace
}  // namespace takt::bench::table1_test
