#include "reports/run_report.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::tool::run_report_test {
namespace {

using json = nlohmann::ordered_json;
using testing::AllOf;
using testing::ContainsRegex;
using testing::HasSubstr;
using testing::Not;

json measured() {
  return {{"mean", -1.5}, {"variance", 0.0}, {"min", 0.0},   {"p50", 0.25},
          {"p99", 12.34}, {"p999", 20.0},    {"max", 1450.4}};
}

json module(const char* name, const char* state) {
  return {{"name", name}, {"state", state},          {"cycles", 1000},      {"overruns", 2},
          {"errors", 3},  {"jitter_us", measured()}, {"run_us", measured()}};
}

json port(const char* name, int connections, int matched) {
  return {{"name", name},       {"direction", "in"}, {"type", "t::T"},   {"connections", connections},
          {"matched", matched}, {"samples", 41},     {"lost", 5},        {"dropped", 6},
          {"refused", 0},       {"late", 7},         {"age_us", 1234.6}, {"incompatible", nullptr}};
}

json cell() {
  json arm = module("arm", "EXECUTING");
  arm["ports"] = json::array({port("setpoint", 2, 1), port("unused", 0, 0)});
  return {{"cell", "c"},
          {"devices", json::array({{{"name", "robot"},
                                    {"alive", true},
                                    {"real_time", true},
                                    {"executors", json::array({{{"name", "main"},
                                                                {"cycles", 999},
                                                                {"missed", 1},
                                                                {"margin_us", 17.5},
                                                                {"jitter_us", measured()}}})},
                                    {"modules", json::array({arm})}}})}};
}

TEST(RunText, ShowsALineForEachModuleAndConnectedPort) {
  const std::string text = run_text(cell());
  EXPECT_THAT(text, ContainsRegex("main +999 +1 +-1.50 +0.25 +12.3 +1450 +17.5"));
  EXPECT_THAT(text, ContainsRegex("arm +EXECUTING +1000 +-1.50 +0.25 +12.3 +0.25 +1450 +2 +3"));
  EXPECT_THAT(text, ContainsRegex("arm.setpoint +in +1/2 +41 +5 +6 +7 +1235\n"));
  EXPECT_THAT(text, Not(HasSubstr("unused")));
}

TEST(RunText, ShowsWhetherTheDevicesHaveDifferentDeployments) {
  json status = cell();
  EXPECT_THAT(run_text(status), Not(HasSubstr("DIFFERENT")));
  status["differences"] = {"the devices of cell a differ"};
  EXPECT_THAT(run_text(status), HasSubstr("\nDIFFERENT DEPLOYMENTS: the devices of cell a differ\n"));
}

TEST(RunText, ShowsHowFarTheClockOfADeviceIsAheadOfTheFirstDevice) {
  json status = cell();
  status["devices"][0]["clock"] = nullptr;
  EXPECT_THAT(run_text(status), HasSubstr("device robot\n"));
  status["devices"][0]["clock"] = {{"reference", "line"}, {"offset_us", 123.4}, {"bound_us", 400.0}};
  EXPECT_THAT(run_text(status), HasSubstr("device robot  clock +0.1 ms ±0.4 ms\n"));
  status["devices"][0]["clock"] = {{"reference", "robot"}, {"offset_us", 0.0}, {"bound_us", 0.0}};
  EXPECT_THAT(run_text(status), HasSubstr("device robot\n"));
}

TEST(RunText, ShowsTheVersionAndHashOfEachComponentIfKnown) {
  json status = cell();
  json& arm = status["devices"][0]["modules"][0];
  arm["file"] = "/c/arm.so";
  arm["version"] = "1.2.0";
  arm["hash"] = "3fa91c02";
  EXPECT_THAT(run_text(status), ContainsRegex("arm +3fa91c02 +1.2.0 +/c/arm.so\n"));
  EXPECT_EQ(components_in(status["devices"][0]).at("arm"), "arm.so 1.2.0 3fa91c02");
  leave_out_components(status);
  EXPECT_EQ(status, cell());
}

TEST(RunJson, OmitsTheWakeMarginsOfExecutors) {
  const json report = json::parse(run_json(cell()));
  std::vector<std::string> keys;
  for (const auto& entry : report["devices"][0]["executors"][0].items()) keys.push_back(entry.key());
  EXPECT_EQ(keys, (std::vector<std::string>{"name", "cycles", "missed", "jitter_us"}));
  EXPECT_EQ(report["devices"][0]["modules"], cell()["devices"][0]["modules"]);
}

TEST(RunText, ShowsTheJudgementOfEachPortWithAMarkAndAColour) {
  json status = cell();
  json& port = status["devices"][0]["modules"][0]["ports"][0];
  EXPECT_THAT(run_text(status), HasSubstr("   late        age\n")) << "a device that has ended judges none";
  port["rating"] = "good";
  port["reason"] = "ok";
  EXPECT_THAT(run_text(status, {.colour = true}),
              AllOf(HasSubstr("   late        age   now\n"), ContainsRegex("7 +1235   ok\n")));
  port["rating"] = "poor";
  port["reason"] = "degraded: drops samples";
  EXPECT_THAT(run_text(status), ContainsRegex("7 +1235 ! degraded: drops samples\n"));
  EXPECT_THAT(run_text(status, {.colour = true}), HasSubstr(" \x1b[33m! degraded: drops samples\x1b[0m\n"));
  port["rating"] = "broken";
  port["reason"] = "not matched: reliability";
  port["age_us"] = nullptr;
  EXPECT_THAT(run_text(status), ContainsRegex("7 +- X not matched: reliability\n"));
  EXPECT_THAT(run_text(status, {.colour = true}), HasSubstr(" \x1b[31mX not matched: reliability\x1b[0m\n"));
}

TEST(RunText, ShowsTheLastKnownStatesOfALostDevice) {
  json status = cell();
  status["devices"][0]["alive"] = false;
  const std::string text = run_text(status);
  EXPECT_THAT(text, AllOf(HasSubstr("device robot  LOST"), ContainsRegex("\n  arm +LOST, was EXECUTING\n")));
  EXPECT_THAT(text, Not(HasSubstr("arm.setpoint")));
  EXPECT_THAT(text,
              HasSubstr("\n  check the network and the machine; if the node has ended, start it again"));
  status["devices"][0]["modules"][0]["state"] = "UNKNOWN";
  EXPECT_THAT(run_text(status), ContainsRegex("\n  arm +LOST\n"));
}

TEST(RunText, ShowsWhyAModuleOrDeviceIsInABadState) {
  json status = cell();
  status["devices"][0]["state"] = "running";
  status["devices"][0]["modules"][0]["state"] = "RECOVER";
  status["devices"][0]["modules"][0]["text"] = "stale: nothing came\nand more";
  EXPECT_THAT(run_text(status), ContainsRegex("arm +RECOVER.*\n    stale: nothing came\n"));
  status["devices"][0]["state"] = "ended";
  status["devices"][0]["text"] = "module arm was given up";
  EXPECT_THAT(run_text(status), HasSubstr("device robot  ended: module arm was given up\n"));
}

TEST(RunText, ShowsThatAModuleIsStoppedOnlyIfAnOperatorStoppedIt) {
  json status = cell();
  status["devices"][0]["modules"][0]["state"] = "START";
  status["devices"][0]["state"] = "running";
  EXPECT_THAT(run_text(status), Not(HasSubstr("stopped"))) << "it waits for its first release";
  status["devices"][0]["modules"][0]["stopped"] = true;
  EXPECT_THAT(run_text(status), ContainsRegex("arm +START \\(stopped\\) +[0-9]"));
}

TEST(RunText, HasNoTablesForADeviceWithoutADeployment) {
  json status = cell();
  status["devices"][0] = {{"name", "robot"},          {"alive", true},
                          {"real_time", true},        {"executors", json::array()},
                          {"modules", json::array()}, {"state", "waiting"}};
  EXPECT_THAT(run_text(status), AllOf(HasSubstr("device robot  waiting\n"), Not(HasSubstr("  executor"))));
}

TEST(RunText, ShowsTheNameConflictOfTwoNodes) {
  json status = cell();
  status["devices"].push_back(status["devices"][0]);
  for (json& device : status["devices"]) device["conflict"] = "another node named robot is on domain 7";
  const std::string line = "device robot\n  NAME CONFLICT: another node named robot is on domain 7\n";
  const std::string text = run_text(status);
  EXPECT_THAT(text, HasSubstr(line));
  EXPECT_NE(text.find(line), text.rfind(line)) << "for each of the two nodes";
}

TEST(RunText, MarksADeviceThatDoesNotRunInRealTime) {
  json status = cell();
  status["devices"][0]["real_time"] = false;
  EXPECT_THAT(run_text(status), HasSubstr("device robot  NOT REAL-TIME"));
}

}  // namespace
}  // namespace takt::tool::run_report_test
