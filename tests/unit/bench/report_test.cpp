#include "report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "surroundings.hpp"

namespace takt::bench::report_test {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

Report report() {
  Report report{.benchmark = "wake"};
  report.machine.processors = 2;
  report.stolen = std::chrono::milliseconds{30};
  report.refused = {fail("SCHED_FIFO 80 is denied", "run as root")};
  report.sections = {{.title = "wake-up",
                      .columns = {"p50 us", "missed"},
                      .rows = {{"hybrid", {0.021, 3}}, {"none", {std::nan(""), 0}}},
                      .notes = {"A sentence."}}};
  return report;
}

TEST(ReportText, AlignsItsColumns) {
  const std::string text = report_text(report());
  EXPECT_THAT(text,
              ContainsRegex("wake-up\n +p50 us +missed\n  hybrid +0.02 +3\n  none +- +0\n  A sentence.\n"));
  EXPECT_THAT(text, HasSubstr("30 ms"));
  EXPECT_THAT(text, HasSubstr("SCHED_FIFO 80 is denied; run as root"));
}

TEST(ReportJson, HasAKeyForEachColumn) {
  const auto json = report_json(report());
  EXPECT_EQ("wake", json["benchmark"]);
  EXPECT_EQ(2, json["machine"]["processors"]);
  const auto& rows = json["sections"][0]["rows"];
  EXPECT_EQ(0.021, rows[0]["p50_us"]);
  EXPECT_EQ(3, rows[0]["missed"]);
  EXPECT_TRUE(rows[1]["p50_us"].is_null());
  EXPECT_EQ(1U, json["refused"].size());
}

TEST(ProblemList, AddsEachProblemOnlyOnce) {
  Problems all;
  add_once(all, {fail("a"), fail("a")});
  add_once(all, {fail("b"), fail("a")});
  EXPECT_EQ((Problems{fail("a"), fail("b")}), all);
}

TEST(TimeColumns, HaveOneHeadingPerValue) {
  EXPECT_EQ(time_columns().size(), in_columns({.count = 1}).size());
  EXPECT_TRUE(std::isnan(in_columns({}).front()));
}

TEST(DescriptionOfTheMachine, DescribesMissingValuesInWords) {
  const std::string text = machine_text({});
  EXPECT_THAT(text, ContainsRegex("governor +none visible"));
  EXPECT_THAT(text, ContainsRegex("isolated +no CPU"));
  EXPECT_THAT(text, ContainsRegex("throttling +off"));
}

TEST(TimeText, HasFewerDecimalsForLargerNumbers) {
  EXPECT_EQ("0.05", in_us(52));
  EXPECT_EQ("-12.3", in_us(-12'300));
  EXPECT_EQ("1450", in_us(1'450'400));
  EXPECT_EQ("2026-11-21 18:15 UTC", date_text(1'795'284'900'000'000'000));
}

}  // namespace
}  // namespace takt::bench::report_test
