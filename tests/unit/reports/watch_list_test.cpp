#include <watch/list.hpp>

#include <gmock/gmock.h>

#include <watch/sparkline.hpp>

#include "watch_cells.hpp"

namespace takt::tool::watch::watch_list_test {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

std::vector<std::string> targets(const Snapshot& snapshot, const View& view) {
  std::vector<std::string> all;
  for (const Row& row : rows_of(snapshot, view)) all.push_back(row.target());
  return all;
}

Snapshot three() {
  Snapshot snapshot = cell(3);
  snapshot.devices[1].modules[0].measured->errors = 2;
  snapshot.devices[1].modules[1].measured->errors = 5;
  snapshot.devices.push_back(device("idle"));
  return snapshot;
}

TEST(WatchList, ListsEachDeviceWithItsModulesBelow) {
  EXPECT_THAT(targets(three(), {}),
              ElementsAre("idle", "line", "line.belt", "robot", "robot.m0", "robot.m1", "robot.m2"));
  EXPECT_THAT(targets(three(), {.reversed = true}),
              ElementsAre("robot", "robot.m2", "robot.m1", "robot.m0", "line", "line.belt", "idle"));
}

TEST(WatchList, SortsLargestNumbersFirst) {
  EXPECT_THAT(targets(three(), {.column = Column::errors}),
              ElementsAre("robot.m1", "robot.m0", "line.belt", "robot.m2", "idle"));
  EXPECT_THAT(targets(three(), {.column = Column::errors, .reversed = true}),
              ElementsAre("idle", "line.belt", "robot.m2", "robot.m0", "robot.m1"));
}

TEST(WatchList, HasAWiderGapBeforeTheHeadingOfTheChart) {
  EXPECT_THAT(drawn(three(), {}, 120), HasSubstr("p99 us  last minute"));
}

TEST(WatchList, SortsWorstStatesFirst) {
  Snapshot snapshot = three();
  snapshot.devices[1].modules[2].state = "DESTRUCT";
  EXPECT_THAT(targets(snapshot, {.column = Column::state}),
              ElementsAre("line.belt", "robot.m2", "robot.m0", "robot.m1", "idle"));
  snapshot.devices[1].alive = false;
  EXPECT_THAT(targets(snapshot, {.column = Column::state}),
              ElementsAre("robot.m0", "robot.m1", "robot.m2", "line.belt", "idle"));
}

TEST(WatchList, PaintsDestructRedOnlyIfTheModuleWasGivenUp) {
  const Device on = device("robot");
  Module one = module("one", "DESTRUCT");
  EXPECT_EQ(state_of(on, one, {}).ink, Ink::dim) << "it has finished, or an operator ended it";
  one.given_up = true;
  EXPECT_EQ(state_of(on, one, {}).ink, Ink::bad);
}

TEST(WatchList, ShowsASafeStopInsteadOfTheState) {
  Snapshot snapshot = cell(2);
  snapshot.devices.erase(snapshot.devices.begin());
  EXPECT_THAT(drawn(snapshot), HasSubstr("all EXECUTING"));
  snapshot.devices[0].modules[1].safe_stop = true;
  EXPECT_EQ(state_of(snapshot.devices[0], snapshot.devices[0].modules[1], {}).ink, Ink::warning);
  EXPECT_THAT(drawn(snapshot), AllOf(HasSubstr("! safe stop"), HasSubstr("1 in a safe stop"),
                                     Not(HasSubstr("all EXECUTING"))));
}

TEST(WatchList, ShowsThatAnInputOfAModuleIsForced) {
  Snapshot snapshot = cell(2);
  Module& module = snapshot.devices[1].modules[1];
  module.forced = true;
  module.text = "forced: in by operator anna";
  EXPECT_EQ(state_of(snapshot.devices[0], module, {}).ink, Ink::warning);
  EXPECT_THAT(drawn(snapshot), AllOf(HasSubstr("! forced"), HasSubstr("in by operator anna"),
                                     HasSubstr("1 forced"), Not(HasSubstr("all EXECUTING"))));
}

TEST(WatchList, CountsTheUnacknowledgedAlarmsOfAllDevices) {
  Snapshot snapshot = cell(2);
  EXPECT_THAT(drawn(snapshot), Not(HasSubstr("alarm")));
  snapshot.devices[0].alarms = 1;
  EXPECT_THAT(drawn(snapshot), HasSubstr("1 unacknowledged alarm  "));
  snapshot.devices[1].alarms = 2;
  EXPECT_THAT(drawn(snapshot), HasSubstr("3 unacknowledged alarms  "));
}

TEST(WatchList, CanBeSortedByEachNumericColumn) {
  Snapshot snapshot = cell(2);
  snapshot.devices.erase(snapshot.devices.begin());
  Module& less = snapshot.devices[0].modules[0];
  Module& more = snapshot.devices[0].modules[1];
  for (Module* each : {&less, &more})
    each->planned = Planned{.words = "", .budget = std::chrono::microseconds{100}};
  more.measured = Measured{.cycles = 2000,
                           .missed = 1,
                           .overruns = 1,
                           .errors = 1,
                           .jitter_us = {.p50 = 9, .p99 = 99},
                           .run_us = {.p99 = 80}};
  for (const Column column : {Column::p50, Column::p99, Column::budget, Column::overruns, Column::errors,
                              Column::cycles, Column::missed})
    EXPECT_THAT(targets(snapshot, {.column = column}), ElementsAre("robot.m1", "robot.m0"))
        << static_cast<int>(column);
}

TEST(WatchList, FiltersByNameStateAndReason) {
  EXPECT_THAT(targets(three(), {.filter = "ROBOT m1"}), ElementsAre("robot", "robot.m1"));
  EXPECT_THAT(targets(three(), {.filter = "recover"}), ElementsAre("line", "line.belt"));
  EXPECT_THAT(targets(three(), {.filter = "jams"}), ElementsAre("line", "line.belt"));
  EXPECT_THAT(targets(three(), {.filter = "waiting"}), ElementsAre("idle"));
  EXPECT_THAT(targets(three(), {.filter = "line"}), ElementsAre("line", "line.belt"));
  EXPECT_THAT(targets(three(), {.column = Column::p99, .filter = "m2"}), ElementsAre("robot.m2"));
  EXPECT_THAT(targets(three(), {.filter = "m1 m2"}), ElementsAre());
}

TEST(WatchList, ShowsTheMostImportantColumnsOnANarrowScreen) {
  const std::string heading = list_heading({}, 80, {}).shown(80, {});
  for (const char* column :
       {"^device, module", "state", "p50 us", "p99 us", "last minute", "budget", "over", "err"})
    EXPECT_THAT(heading, HasSubstr(column));
  EXPECT_THAT(heading, Not(HasSubstr("cycles")));
  EXPECT_THAT(list_heading({}, 200, {}).shown(200, {}), HasSubstr("missed"));
  EXPECT_THAT(list_heading({.column = Column::p99}, 80, {}).shown(80, {}), HasSubstr("vp99 us"));
  EXPECT_THAT(list_heading({.column = Column::p99, .reversed = true}, 80, {}).shown(80, {}),
              HasSubstr("^p99 us"));
}

TEST(WatchList, ReplacesNumbersByTheReasonOnANarrowScreen) {
  const Snapshot snapshot = cell(1);
  const Row belt = rows_of(snapshot, {})[1];
  const std::string narrow = list_line(belt, false, 80, {}).shown(80, {});
  EXPECT_THAT(narrow, HasSubstr("! RECOVER    failure: it jams"));
  EXPECT_THAT(narrow, Not(HasSubstr("20.2")));
  const std::string wide = list_line(belt, true, 180, {}).shown(180, {});
  EXPECT_THAT(wide, HasSubstr("20.2"));
  EXPECT_THAT(wide, HasSubstr("failure: it jams"));
  EXPECT_THAT(wide, testing::StartsWith(">   belt"));
}

TEST(WatchList, ShowsThatAModuleIsStoppedIfTheColumnIsWideEnough) {
  Snapshot snapshot = cell(1);
  Module& belt = snapshot.devices[0].modules[0];
  belt = {.name = "belt", .state = "START", .stopped = true};
  const auto line = [&](std::size_t columns) {
    return list_line(rows_of(snapshot, {})[1], false, columns, {}).shown(columns, {});
  };
  EXPECT_THAT(line(100), HasSubstr("o START (stopped)"));
  EXPECT_THAT(line(80), HasSubstr("o START  "));
  belt.stopped = false;
  EXPECT_THAT(line(100), Not(HasSubstr("stopped")));
}

TEST(WatchList, ShowsThe99thPercentileAsAShareOfTheBudget) {
  Snapshot snapshot = cell(1);
  Module& m0 = snapshot.devices[1].modules[0];
  const auto line = [&] {
    return list_line(rows_of(snapshot, {})[3], false, 80, {.colour = true}).shown(80, {.colour = true});
  };
  EXPECT_THAT(line(), Not(HasSubstr("%")));
  m0.planned = Planned{.words = "", .budget = std::chrono::microseconds{200}};
  EXPECT_THAT(line(), HasSubstr(" 25 %"));
  m0.planned->budget = std::chrono::microseconds{40};
  EXPECT_THAT(line(), HasSubstr("\033[31m125 %"));
  m0.measured.reset();
  EXPECT_THAT(line(), Not(HasSubstr("%")));
}

TEST(WatchSparkline, RisesOneStepWhenTheValueTriples) {
  const std::vector<double> values{0, 0.9, 1, 3, 10, 30, 100, 300, 1000, 1e9};
  EXPECT_EQ(sparkline(values, 10, {.unicode = true}), "▁▁▂▃▄▅▆▇██");
  EXPECT_EQ(sparkline(values, 10, {}), "__.,-=+*##");
}

TEST(WatchSparkline, ShowsTheNewestValuesWithGapsForMissingOnes) {
  const double none = std::nan("");
  EXPECT_EQ(sparkline({1000, 0, none, 1}, 3, {}), "_ .");
  EXPECT_EQ(sparkline({1}, 3, {}), "  .");
  EXPECT_EQ(sparkline({}, 2, {}), "  ");
  EXPECT_EQ(sparkline({1}, 0, {}), "");
}

TEST(WatchChart, IsScaledFromZeroToTheLargestValue) {
  const double none = std::nan("");
  EXPECT_THAT(chart({0, 8, none, 16}, 4, 2, {.unicode = true}), ElementsAre("   █", "▁█ █"));
  EXPECT_THAT(chart({none}, 1, 1, {.unicode = true}), ElementsAre(" "));
  EXPECT_THAT(chart({0}, 1, 1, {.unicode = true}), ElementsAre("▁"));
}

TEST(WatchBar, IsFullAtOneHundredPercentOrMore) {
  EXPECT_EQ(bar(0, 4, {}), "....");
  EXPECT_EQ(bar(0.5, 4, {}), "##..");
  EXPECT_EQ(bar(1, 4, {}), "####");
  EXPECT_EQ(bar(7, 4, {}), "####");
  EXPECT_EQ(bar(0.375, 2, {.unicode = true}), "▊·");
}

TEST(WatchState, NamesTheProblemOfAConnection) {
  const auto of = [](const CellHealth::Connection& health) {
    return state_of(Connection{.from = "", .to = "", .kind = "", .health = health}, {});
  };
  EXPECT_EQ(of({.age = std::chrono::milliseconds{2}}).text, "* ok, 2 ms old");
  EXPECT_EQ(of({.age = std::chrono::milliseconds{2}}).ink, Ink::good);
  EXPECT_EQ(of({.age = std::chrono::milliseconds{2}, .losing = true, .lost = 3}).ink, Ink::warning);
  EXPECT_EQ(of({.age = std::chrono::milliseconds{2}, .lost = 3, .late = 4}).ink, Ink::good);
  EXPECT_EQ(of({.age = std::chrono::milliseconds{2}, .dropping = true, .dropped = 27757}).text,
            "! degraded: drops samples, 2 ms old, dropped 27757");
  EXPECT_EQ(of({.matched = false}).text, "X NOT MATCHED");
  EXPECT_EQ(of({.deadline = std::chrono::milliseconds{2}}).text, "! STALE");
  EXPECT_EQ(of({.safe = true, .age = std::chrono::seconds{1}}).text, "! SAFE VALUE, 1 s old");
  EXPECT_EQ(of({}).text, "* ok: no value yet");
  EXPECT_EQ(of({}).ink, Ink::good);
  EXPECT_EQ(of({.incompatible = "reliability"}).ink, Ink::bad);
}

}  // namespace
}  // namespace takt::tool::watch::watch_list_test
