#include <takt/model/difference.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace takt::model::difference_test {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

Module module(const std::string& name) {
  Module module;
  module.name = name;
  module.filename = name + ".so";
  module.period = 1ms;
  module.executor = "main";
  module.properties = {{"gain", "0.5"}, {"label", "a"}};
  return module;
}

/// Returns a cell with two devices. Device robot has the modules arm and hand. Device line has the module
/// belt, which writes to an input of arm.
Cell cell() {
  Cell cell;
  cell.name = "cell";
  cell.file = "c.xml";
  cell.line = 1;
  Device robot;
  robot.name = "robot";
  robot.executors.emplace_back();
  robot.modules = {module("arm"), module("hand")};
  Device line;
  line.name = "line";
  line.executors.emplace_back();
  line.modules = {module("belt")};
  cell.devices = {robot, line};
  Connection connection;
  connection.from = {"line", "belt", "out"};
  connection.to = {"robot", "arm", "in"};
  cell.connections = {connection};
  return cell;
}

using Edit = std::function<void(Cell&)>;

/// Applies an edit to a copy of cell(). Returns the differences between the two cells for the devices robot
/// and line.
std::vector<DeviceDifference> after(const Edit& edit) {
  Cell changed = cell();
  edit(changed);
  auto all = differences(cell(), changed);
  EXPECT_TRUE(all.ok());
  return all.ok() ? *all : std::vector<DeviceDifference>{};
}
DeviceDifference robot_after(const Edit& edit) {
  auto all = after(edit);
  EXPECT_EQ(all.at(1).change, Change::none) << "only one device differs";
  return all.at(0);
}
Module& arm(Cell& cell) { return cell.devices[0].modules[0]; }

TEST(CellUpdate, IsEmptyBetweenEqualCells) {
  const auto all = after([](Cell&) {});
  ASSERT_THAT(all, SizeIs(2));
  for (const DeviceDifference& one : all) {
    EXPECT_EQ(one.change, Change::none);
    EXPECT_THAT(in_words(one), IsEmpty());
  }
}

TEST(CellUpdate, IgnoresLineNumbersAndTheOrderOfProperties) {
  const auto all = after([](Cell& changed) {
    changed.file = "other.xml";
    changed.line = 7;
    changed.devices[0].line = 8;
    arm(changed).line = 9;
    arm(changed).properties[0].line = 10;
    changed.connections[0].line = 11;
    std::swap(arm(changed).properties[0], arm(changed).properties[1]);
  });
  for (const DeviceDifference& one : all) EXPECT_EQ(one.change, Change::none) << one.device;
}

TEST(CellUpdate, ChangesAPropertyOfAThreadModuleInPlace) {
  const auto robot = robot_after([](Cell& changed) { arm(changed).properties[0].value = "0.7"; });
  EXPECT_EQ(robot.change, Change::in_place);
  ASSERT_THAT(robot.in_place, SizeIs(1));
  EXPECT_EQ(robot.in_place[0].module, "arm");
  EXPECT_EQ(robot.in_place[0].property, "gain");
  EXPECT_EQ(robot.in_place[0].value, "0.7");
  EXPECT_THAT(in_words(robot), ElementsAre("robot.arm: gain: 0.5 -> 0.7"));
}

TEST(CellUpdate, SetsAnAddedPropertyInPlace) {
  const auto robot = robot_after([](Cell& changed) { arm(changed).properties.push_back({"limit", "3"}); });
  EXPECT_THAT(in_words(robot), ElementsAre("robot.arm: limit: not set -> 3"));
}

TEST(CellUpdate, RestartsTheDeviceIfAPropertyIsNoLongerSet) {
  const auto robot = robot_after([](Cell& changed) { arm(changed).properties.pop_back(); });
  EXPECT_EQ(robot.change, Change::anew);
  EXPECT_THAT(in_words(robot), ElementsAre("robot is restarted: module arm: label is no longer set"));
}

TEST(CellUpdate, ChangesTheLogLevelOfAnyModuleInPlaceEvenBackToTheDefault) {
  Cell plain = cell();
  arm(plain).type = ModuleType::process;
  Cell debug = plain;
  arm(debug).properties.push_back({"log-level", "debug"});
  auto all = differences(plain, debug);
  ASSERT_TRUE(all.ok());
  EXPECT_EQ((*all)[0].change, Change::in_place);
  EXPECT_THAT(in_words((*all)[0]), ElementsAre("robot.arm: log-level: not set -> debug"));
  all = differences(debug, plain);
  ASSERT_TRUE(all.ok());
  EXPECT_EQ((*all)[0].change, Change::in_place);
  ASSERT_THAT((*all)[0].in_place, SizeIs(1));
  EXPECT_EQ((*all)[0].in_place[0].value, "info");
  EXPECT_THAT(in_words((*all)[0]), ElementsAre("robot.arm: log-level: debug -> info, the default"));
}

TEST(CellUpdate, SetsPropertiesBeforeItSwapsAModuleInPlace) {
  const auto robot = robot_after([](Cell& changed) {
    arm(changed).filename = "arm2.so";
    arm(changed).properties[1].value = "b";
    changed.devices[0].modules[1].filename = "hand2.so";
  });
  EXPECT_EQ(robot.change, Change::in_place);
  ASSERT_THAT(robot.in_place, SizeIs(3));
  EXPECT_EQ(robot.in_place[1].property, "");
  EXPECT_EQ(robot.in_place[1].value, "arm2.so");
  EXPECT_THAT(in_words(robot), ElementsAre("robot.arm: label: a -> b; file: arm.so -> arm2.so",
                                           "robot.hand: file: hand.so -> hand2.so"));
}

TEST(CellUpdate, RestartsTheDeviceIfAChangeCannotBeMadeInPlace) {
  Cell before = cell();
  arm(before).operation = Operation::sporadic;
  arm(before).period.reset();
  arm(before).deadline = 5ms;
  Cell changed = before;
  arm(changed).filename = "arm2.so";
  arm(changed).properties[0].value = "1";
  auto all = differences(before, changed);
  ASSERT_TRUE(all.ok());
  EXPECT_EQ((*all)[0].change, Change::anew);
  EXPECT_THAT((*all)[0].in_place, IsEmpty());
  EXPECT_THAT((*all)[0].reasons,
              ElementsAre("module arm: file: arm.so -> arm2.so", "module arm: gain: 0.5 -> 1"));

  arm(before).type = arm(changed).type = ModuleType::process;
  all = differences(before, changed);
  ASSERT_TRUE(all.ok());
  EXPECT_THAT((*all)[0].reasons,
              ElementsAre("module arm: gain: 0.5 -> 1", "module arm: file: arm.so -> arm2.so"));
}

TEST(CellUpdate, ReportsAChangeOfAnyElementOfAModule) {
  const std::vector<std::pair<Edit, std::string>> cases{
      {[](Cell& c) { arm(c).type = ModuleType::process; }, "moduletype: thread -> process"},
      {[](Cell& c) { arm(c).operation = Operation::non_real; }, "operationtype: periodic -> non-real"},
      {[](Cell& c) { arm(c).period = 2ms; }, "period: 1 ms -> 2 ms"},
      {[](Cell& c) { arm(c).offset = 5us; }, "offset: none -> 5 us"},
      {[](Cell& c) { arm(c).deadline = 1s; }, "deadline: none -> 1 s"},
      {[](Cell& c) { arm(c).miss = Miss::error; }, "miss: count -> error"},
      {[](Cell& c) { arm(c).dispatch = Dispatch::immediate; }, "dispatch: row -> immediate"},
      {[](Cell& c) { arm(c).interarrival = 1ms; }, "interarrival: none -> 1 ms"},
      {[](Cell& c) { arm(c).priority = 3; }, "priority: 0 -> 3"},
      {[](Cell& c) { arm(c).executor = "fast"; }, "executor: main -> fast"},
      {[](Cell& c) { arm(c).budget = 100us; }, "budget: none -> 100 us"},
      {[](Cell& c) { arm(c).hang = 30ms; }, "hang: none -> 30 ms"},
      {[](Cell& c) { arm(c).tolerance.times = 2; },
       "budget tolerance: times none, in a row none -> times 2, in a row none"},
      {[](Cell& c) {
         arm(c).overrun = OverrunContract{Overrun::catch_up, 4};
       },
       "overrun: none -> catch-up 4"},
      {[](Cell& c) { arm(c).recovery.attempts = 1; },
       "recovery: 3 attempts, backoff 100 ms, then destruct -> 1 attempts, backoff 100 ms, then destruct"},
      {[](Cell& c) { arm(c).retain = true; }, "retain: no -> yes"},
      {[](Cell& c) {
         arm(c).arguments = {"--camera", "0", "a lens", ""};
       },
       "arguments: none -> --camera 0 'a lens' ''"},
      {[](Cell& c) {
         arm(c).safe = {{"out", {{"x", "1"}, {"y", "2"}}}};
       },
       "safe: none -> out {x: 1, y: 2}"},
  };
  for (const auto& [edit, words] : cases) {
    const auto robot = robot_after(edit);
    EXPECT_EQ(robot.change, Change::anew) << words;
    EXPECT_THAT(robot.reasons, ElementsAre("module arm: " + words));
  }
}

TEST(CellUpdate, ReportsAChangeOfAnyAttributeOfAnExecutor) {
  const auto main = [](Cell& c) -> Executor& { return c.devices[0].executors[0]; };
  const std::vector<std::pair<Edit, std::string>> cases{
      {[&](Cell& c) { main(c).cpu = 1; }, "cpu: none -> 1"},
      {[&](Cell& c) { main(c).priority = 70; }, "priority: 80 -> 70"},
      {[&](Cell& c) { main(c).rate_monotonic = true; }, "rate-monotonic: no -> yes"},
      {[&](Cell& c) { main(c).wakeup = Wakeup::sleep; }, "wakeup: hybrid -> sleep"},
      {[&](Cell& c) { main(c).spin_share = 0.25; }, "spin: 0.4 -> 0.25"},
      {[&](Cell& c) { main(c).overrun.what = Overrun::error; }, "overrun: skip -> error"},
      {[&](Cell& c) { main(c).offsets = Offsets::automatic; }, "offsets: given -> auto"},
      {[&](Cell& c) { main(c).timing = Timing::let; }, "timing: direct -> let"},
      {[&](Cell& c) { main(c).own_host = true; }, "own host: no -> yes"},
  };
  for (const auto& [edit, words] : cases)
    EXPECT_THAT(robot_after(edit).reasons, ElementsAre("executor main: " + words));
}

TEST(CellUpdate, ReportsAddedRemovedAndReorderedElements) {
  EXPECT_THAT(robot_after([](Cell& c) { c.devices[0].modules.push_back(module("eye")); }).reasons,
              ElementsAre("module eye is new"));
  EXPECT_THAT(robot_after([](Cell& c) { c.devices[0].modules.pop_back(); }).reasons,
              ElementsAre("module hand is removed"));
  EXPECT_THAT(
      robot_after([](Cell& c) { std::swap(c.devices[0].modules[0], c.devices[0].modules[1]); }).reasons,
      ElementsAre("the order of the modules has changed"));
  EXPECT_THAT(robot_after([](Cell& c) { c.devices[0].executors.emplace_back().name = "slow"; }).reasons,
              ElementsAre("executor slow is new"));
}

TEST(CellUpdate, ListsAChangedConnectionUnderBothItsDevices) {
  const auto both = [](const Edit& edit, const std::string& reason) {
    for (const DeviceDifference& one : after(edit)) {
      EXPECT_EQ(one.change, Change::anew) << one.device;
      EXPECT_THAT(one.reasons, testing::Contains("connection line.belt.out -> robot.arm.in" + reason));
    }
  };
  const auto only = [](Cell& c) -> Connection& { return c.connections[0]; };
  both([&](Cell& c) { only(c).kind = ConnectionKind::queue; }, ": kind: latest -> queue");
  both([&](Cell& c) { only(c).depth = 3; }, ": depth: 1 -> 3");
  both([&](Cell& c) { only(c).reliability = Reliability::reliable; },
       ": reliability: best-effort -> reliable");
  both([&](Cell& c) { only(c).deadline = 1ms; }, ": deadline: none -> 1 ms");
  both([&](Cell& c) { only(c).lifespan = 1ms; }, ": lifespan: none -> 1 ms");
  both([&](Cell& c) { only(c).stale = Stale::error; }, ": stale: hold -> error");
  both([&](Cell& c) { only(c).topic = "t"; }, ": topic: none -> t");
  both([&](Cell& c) { only(c).domain = 3; }, ": domain: none -> 3");
  both([](Cell& c) { c.connections.clear(); }, " is removed");
  // A changed safe value of an output also changes the device that reads the output.
  both([](Cell& c) { c.devices[1].modules[0].safe = {{"out", {{"x", "1"}}}}; }, ": safe: none -> out {x: 1}");
}

TEST(CellUpdate, ReportsAddedAndRemovedDevices) {
  const auto all = after([](Cell& c) {
    c.devices[1].name = "belt";
    c.connections.clear();
  });
  ASSERT_THAT(all, SizeIs(3));
  EXPECT_EQ(all[1].change, Change::added);
  EXPECT_THAT(in_words(all[1]), ElementsAre("belt is new"));
  EXPECT_EQ(all[2].change, Change::removed);
  EXPECT_THAT(in_words(all[2]), ElementsAre("line is stopped: it is no longer in the cell"));
}

TEST(CellUpdate, RejectsChangesThatAffectTheWholeCell) {
  const std::vector<std::pair<Edit, std::string>> cases{
      {[](Cell& c) { c.name = "other"; }, "name: cell -> other"},
      {[](Cell& c) { c.domain_given = true; }, "domain: none -> 0"},
      {[](Cell& c) {
         c.discovery.kind = Discovery::Kind::peers;
         c.discovery.peers = {"10.0.0.1"};
       },
       "discovery: multicast -> peers 10.0.0.1"},
      {[](Cell& c) { c.server_device = "line"; }, "discovery server device: none -> line"},
      {[](Cell& c) { c.security_required = true; }, "required security: no -> yes"},
  };
  for (const auto& [edit, words] : cases) {
    Cell changed = cell();
    edit(changed);
    const auto all = differences(cell(), changed);
    ASSERT_FALSE(all.ok()) << words;
    ASSERT_THAT(all.problems(), SizeIs(1));
    EXPECT_EQ(all.problems()[0].where, "c.xml:1");
    EXPECT_THAT(all.problems()[0].what, HasSubstr(words));
    EXPECT_THAT(all.problems()[0].fix, HasSubstr("undeploy"));
  }
}

TEST(CellUpdate, ListsTheReasonForARestartFirst) {
  auto robot = robot_after([](Cell& changed) { arm(changed).properties[0].value = "0.7"; });
  robot.make_anew("module arm reads gain in initialize() alone");
  EXPECT_EQ(robot.change, Change::anew);
  EXPECT_THAT(in_words(robot), ElementsAre("robot is restarted: module arm reads gain in initialize() alone; "
                                           "module arm: gain: 0.5 -> 0.7"));
}

}  // namespace
}  // namespace takt::model::difference_test
