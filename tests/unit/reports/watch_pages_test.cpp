#include <watch/pages.hpp>

#include <gmock/gmock.h>

#include "watch_cells.hpp"

namespace takt::tool::watch::watch_pages_test {
namespace {

using testing::HasSubstr;
using testing::Not;

std::string text_of(const std::vector<Line>& page, ScreenStyle style = {}) {
  std::string text;
  for (const Line& line : page) text += line.shown(80, style) + "\n";
  return text;
}

TEST(WatchDetails, ShowAllDataOfAModule) {
  Snapshot snapshot = cell(1);
  Module& m = snapshot.devices[1].modules[0];
  m.text = "because";
  m.planned = Planned{.words = "thread, periodic, every 1 ms",
                      .executor = "motion",
                      .priority = 3,
                      .period = std::chrono::milliseconds{1},
                      .budget = std::chrono::microseconds{200}};
  m.measured = Measured{.cycles = 12345,
                        .missed = 11,
                        .overruns = 12,
                        .over_budget = 13,
                        .errors = 14,
                        .recoveries = 15,
                        .jitter_us = {.p50 = 1.25, .p99 = 22.5, .p999 = 333.4, .max = 4444},
                        .run_us = {.p50 = 50, .p99 = 100, .p999 = 150, .max = 250}};
  m.minute_us = {1, 2, 64};
  m.ports = {{.name = "setpoint",
              .output = false,
              .type = "motion::Setpoint",
              .connected = true,
              .samples = 77,
              .health = {.deadline = std::chrono::milliseconds{20}},
              .source = "line.plan.out"},
             {.name = "spare", .output = true, .type = "motion::State"}};
  snapshot.values = {{"line.plan.out", "angle: 1.25"}};
  m.transitions = {{.time_ns = 0, .text = "IDLE -> INITIALIZE"},
                   {.time_ns = 1, .text = "INITIALIZE -> START"}};
  const std::string page = text_of(details_page(snapshot, "robot.m0", 80, {}));
  for (const char* part : {"* EXECUTING",
                           "because",
                           "thread, periodic, every 1 ms",
                           "motion, priority 3",
                           "budget       200 us",
                           "cycles       12345",
                           "missed 11",
                           "overruns 12",
                           "over budget 13",
                           "errors       14",
                           "recoveries 15",
                           "p50 1.25   p99 22.5   p99.9 333.4   max 4444 us",
                           "64.0 us",
                           "25 %",
                           "50 %",
                           "125 % OVER",
                           "in  setpoint",
                           "motion::Setpoint",
                           "77 ! STALE",
                           "\n      angle: 1.25\n",
                           "out spare",
                           "not connected",
                           "INITIALIZE -> START"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_LT(page.find("INITIALIZE -> START"), page.find("IDLE -> INITIALIZE")) << "newest first";
}

TEST(WatchDetails, SayWhichDataOfAModuleIsMissing) {
  Snapshot snapshot = cell(1);
  Module& m = snapshot.devices[1].modules[0];
  EXPECT_THAT(text_of(details_page(snapshot, "robot.m0", 80, {})),
              HasSubstr("last minute  the module did not run"));
  m.planned = Planned{.words = "thread"};
  EXPECT_THAT(text_of(details_page(snapshot, "robot.m0", 80, {})),
              HasSubstr("the descriptor gives no budget"));
  m.measured.reset();
  EXPECT_THAT(text_of(details_page(snapshot, "robot.m0", 80, {})), HasSubstr("no measurements yet"));
  snapshot.devices[1].alive = false;
  const std::string lost = text_of(details_page(snapshot, "robot.m0", 80, {}));
  EXPECT_THAT(lost, HasSubstr("X LOST"));
  EXPECT_THAT(lost, HasSubstr("these are the last known values"));
}

TEST(WatchDetails, WrapALongReasonBetweenWords) {
  Snapshot snapshot = cell(1);
  for (int i = 0; i < 40; ++i) snapshot.devices[1].modules[0].text += "word" + std::to_string(i) + " ";
  snapshot.devices[1].modules[0].text += std::string(200, 'z') + " end";
  const std::string page = text_of(details_page(snapshot, "robot.m0", 80, {}));
  for (int i = 0; i < 40; ++i) EXPECT_THAT(page, HasSubstr("word" + std::to_string(i)));
  EXPECT_EQ(std::count(page.begin(), page.end(), 'z'), 200) << page;
  EXPECT_THAT(page, Not(HasSubstr("~")));
}

TEST(WatchDetails, ShowHealthAndExecutorsOfADevice) {
  Snapshot snapshot = cell(2);
  Device& robot = snapshot.devices[1];
  robot.machine = "pc7";
  robot.health = "degraded";
  robot.text = "module m1 is in RECOVER";
  robot.real_time = false;
  robot.process_id = 321;
  robot.host_process_id = 654;
  robot.host_restarts = 2;
  robot.executors = {{.name = "motion",
                      .cycles = 999,
                      .missed = 8,
                      .late = 7,
                      .margin_us = 98.75,
                      .jitter_us = {.p50 = 1, .p99 = 2, .max = 3}}};
  const std::string page = text_of(details_page(snapshot, "robot", 80, {}));
  for (const char* part : {"! running", "degraded", "module m1 is in RECOVER", "pc7", "process 321",
                           "process 654", "restarted 2 times", "NO: the system denies real-time scheduling",
                           "2, 2 EXECUTING", "motion", "999", "98.8", "max us"})
    EXPECT_THAT(page, HasSubstr(part));
}

TEST(WatchConnections, ListFaultyConnectionsFirst) {
  Snapshot snapshot;
  snapshot.connections_known = true;
  EXPECT_THAT(text_of(connections_page(snapshot, "", 80, {})), HasSubstr("the cell has no connections"));
  snapshot.connections = {
      {.from = "a.a.a",
       .to = "b.b.b",
       .kind = "latest",
       .health = CellHealth::Connection{.age = std::chrono::milliseconds{1}}},
      {.from = "c.c.c", .to = "d.d.d", .kind = "latest", .health = CellHealth::Connection{.matched = false}},
      {.from = "e.e.e", .to = "f.f.f", .kind = "latest"}};
  const std::string page = text_of(connections_page(snapshot, "", 80, {}));
  EXPECT_LT(page.find("d.d.d"), page.find("b.b.b"));
  EXPECT_THAT(page, HasSubstr("X NOT MATCHED"));
  EXPECT_THAT(page, HasSubstr("not reported"));
  EXPECT_THAT(text_of(connections_page(snapshot, "a.a ok", 80, {})), Not(HasSubstr("c.c.c")));
  EXPECT_THAT(text_of(connections_page(snapshot, "zz", 80, {})),
              HasSubstr("no connections match the filter"));
}

TEST(WatchConnections, ShortenNamesRatherThanTheHealth) {
  Snapshot snapshot;
  snapshot.connections_known = true;
  snapshot.connections = {{.from = std::string(60, 'a'),
                           .to = std::string(60, 'b'),
                           .kind = "latest",
                           .health = CellHealth::Connection{.age = std::chrono::milliseconds{123}}}};
  EXPECT_THAT(text_of(connections_page(snapshot, "", 80, {})), HasSubstr("* ok, 123 ms old"));
}

TEST(WatchHelp, FitsATerminalOfEightyColumns) {
  const std::string page = text_of(help_page({}));
  EXPECT_THAT(page, Not(HasSubstr("~")));
  EXPECT_LE(std::count(page.begin(), page.end(), '\n'), 20);
  for (const char* verb : {"start", "stop", "recover", "reset", "initialize", "destruct"})
    EXPECT_THAT(page, HasSubstr(verb));
}

}  // namespace
}  // namespace takt::tool::watch::watch_pages_test
