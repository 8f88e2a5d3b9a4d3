#include "reports/profile_report.hpp"

#include <gtest/gtest.h>

namespace takt::tool::profile_report_test {
namespace {

using json = nlohmann::ordered_json;

json module(const char* name, int cycles, double max) {
  return {{"name", name},
          {"cycles", cycles},
          {"run_us", {{"min", 0.1}, {"p50", 0.2}, {"p99", 1.001}, {"p999", max}, {"max", max}}}};
}

TEST(ProfileReport, ContainsTheRunTimesOfEveryModule) {
  const json status{{"cell", "cell"},
                    {"devices",
                     {{{"name", "robot"}, {"modules", {module("servo", 7, 886.123)}}},
                      {{"name", "lost"}, {"modules", json::array()}}}}};
  const model::Profile profile = profile_of(status);
  EXPECT_EQ(profile.cell, "cell");
  ASSERT_EQ(profile.modules.size(), 1U);
  const model::RunTimes& servo = profile.modules.at("robot.servo");
  EXPECT_EQ(servo.runs, 7U);
  EXPECT_EQ(servo.min, Nanoseconds{100});
  EXPECT_EQ(servo.p50, Nanoseconds{200});
  EXPECT_EQ(servo.p99, Nanoseconds{1001});
  EXPECT_EQ(servo.max, Nanoseconds{886'123});
}

TEST(ProfileReport, CountsNoRunsIfNoneWasMeasured) {
  json never = module("m", 3, 0);
  for (auto& time : never["run_us"]) time = 0.0;
  const json status{{"cell", "cell"}, {"devices", {{{"name", "robot"}, {"modules", {never}}}}}};
  EXPECT_EQ(profile_of(status).modules.at("robot.m").runs, 0U);
}

}  // namespace
}  // namespace takt::tool::profile_report_test
