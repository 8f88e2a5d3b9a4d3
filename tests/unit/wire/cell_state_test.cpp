#include <takt/wire/cell_state.hpp>

#include <gmock/gmock.h>

#include <takt/wire/words.hpp>

namespace takt::wire::cell_state_test {
namespace {

DeviceStatus device(const std::string& cell, const std::string& name, const std::string& node) {
  DeviceStatus status;
  set(status.path(), path_of(cell, name));
  set(status.cell(), cell);
  set(status.device(), name);
  set(status.node(), node);
  return status;
}

LifecycleStatus module(const std::string& name, LifecycleState state) {
  LifecycleStatus status;
  set(status.path(), path_of("cell", "robot", name));
  set(status.cell(), "cell");
  set(status.device(), "robot");
  set(status.name(), name);
  status.state(state);
  return status;
}

template <class Status>
Status only_key(const Status& whole) {
  Status key;
  key.path(whole.path());
  return key;
}

TEST(CellState, IsEmptyAtFirst) {
  CellState cell_state;
  EXPECT_TRUE(cell_state.devices().empty());
  EXPECT_TRUE(cell_state.devices("robot").empty());
  cell_state.lost(7);
  cell_state.remove(device("-", "robot", ""), 7);
  cell_state.remove(module("servo", STATE_IDLE));
  EXPECT_TRUE(cell_state.devices().empty());
}

TEST(CellState, KeepsAModuleStateThatArrivesBeforeTheStatusOfTheDevice) {
  CellState cell_state;
  cell_state.receive(module("servo", STATE_START));
  EXPECT_TRUE(cell_state.devices().empty());
  cell_state.receive(device("cell", "robot", "a"), 1);
  ASSERT_EQ(cell_state.devices().size(), 1U);
  EXPECT_EQ(cell_state.devices()[0].deployment.modules.at("servo").state(), STATE_START);
}

TEST(CellState, ShowsAModuleAsExecutingOnlyOnALiveDevice) {
  CellState cell_state;
  EXPECT_FALSE(cell_state.executes("cell", "robot", "servo"));
  cell_state.receive(module("servo", STATE_EXECUTING));
  EXPECT_FALSE(cell_state.executes("cell", "robot", "servo")) << "its device is not known";
  DeviceStatus robot = device("cell", "robot", "a");
  robot.sequence_number(1);
  cell_state.receive(robot, 1);
  EXPECT_TRUE(cell_state.executes("cell", "robot", "servo"));
  EXPECT_FALSE(cell_state.executes("cell", "robot", "arm"));
  EXPECT_FALSE(cell_state.executes("other", "robot", "servo"));
  cell_state.receive(module("servo", STATE_RECOVER));
  EXPECT_FALSE(cell_state.executes("cell", "robot", "servo"));
}

TEST(CellState, ShowsModulesOfAReturnedDeviceAsExecutingAfterItsSecondStatus) {
  CellState cell_state;
  DeviceStatus robot = device("cell", "robot", "a");
  robot.sequence_number(5);
  cell_state.receive(robot, 1);
  cell_state.receive(module("servo", STATE_EXECUTING));
  cell_state.lost(1);
  EXPECT_FALSE(cell_state.executes("cell", "robot", "servo"));
  robot.sequence_number(9);
  cell_state.receive(robot, 1);
  EXPECT_FALSE(cell_state.executes("cell", "robot", "servo")) << "the module may have stopped meanwhile";
  robot.sequence_number(10);
  cell_state.receive(robot, 1);
  EXPECT_TRUE(cell_state.executes("cell", "robot", "servo"));
}

TEST(CellState, KeepsTheLastStateOfALostDevice) {
  CellState cell_state;
  cell_state.receive(device("cell", "robot", "a"), 1);
  cell_state.receive(device("cell", "line", "b"), 2);
  cell_state.receive(module("servo", STATE_EXECUTING));
  cell_state.lost(1);
  ASSERT_EQ(cell_state.devices("robot").size(), 1U);
  EXPECT_FALSE(cell_state.devices("robot")[0].alive);
  EXPECT_EQ(cell_state.devices("robot")[0].deployment.modules.at("servo").state(), STATE_EXECUTING);
  EXPECT_TRUE(cell_state.devices("line")[0].alive);
}

TEST(CellState, HasLostADeviceOnlyIfAllItsNodesAreLost) {
  CellState cell_state;
  EXPECT_FALSE(cell_state.has_lost("robot")) << "it has never been known";
  cell_state.receive(device("cell", "robot", "a"), 1);
  cell_state.receive(device("-", "robot", "b"), 2);
  cell_state.lost(1);
  EXPECT_FALSE(cell_state.has_lost("robot"));
  cell_state.lost(2);
  EXPECT_TRUE(cell_state.has_lost("robot"));
  EXPECT_FALSE(cell_state.has_lost("line"));
  cell_state.receive(device("cell", "robot", "a"), 1);
  EXPECT_FALSE(cell_state.has_lost("robot"));
}

TEST(CellState, ShowsALostDeviceAsAliveAfterANewStatus) {
  CellState cell_state;
  cell_state.receive(device("cell", "robot", "a"), 1);
  cell_state.lost(1);
  cell_state.receive(device("cell", "robot", "a"), 1);
  EXPECT_TRUE(cell_state.devices("robot")[0].alive);
}

TEST(CellState, ReplacesALostNodeWithANewNodeOfTheSameName) {
  CellState cell_state;
  cell_state.receive(device("cell", "robot", "a"), 1);
  cell_state.lost(1);
  cell_state.receive(device("-", "robot", "b"), 2);
  ASSERT_EQ(cell_state.devices("robot").size(), 1U);
  EXPECT_EQ(cell_state.devices("robot")[0].node(), "b");
  EXPECT_TRUE(cell_state.devices("robot")[0].deployment.modules.empty());
}

TEST(CellState, DoesNotAssignTheModulesOfALostNodeToANewNode) {
  CellState cell_state;
  cell_state.receive(device("cell", "robot", "a"), 1);
  cell_state.receive(module("servo", STATE_EXECUTING));
  cell_state.lost(1);
  cell_state.receive(device("-", "robot", "b"), 2);
  cell_state.receive(device("cell", "robot", "b"), 2);
  EXPECT_TRUE(cell_state.devices("robot")[0].deployment.modules.empty());
}

TEST(CellState, KeepsModulesReceivedBeforeTheStatusOfARestartedNode) {
  CellState cell_state;
  cell_state.receive(device("cell", "robot", "a"), 1);
  cell_state.lost(1);
  cell_state.receive(module("servo", STATE_IDLE));
  cell_state.receive(device("cell", "robot", "b"), 2);
  EXPECT_EQ(cell_state.devices("robot")[0].deployment.modules.at("servo").state(), STATE_IDLE);
}

TEST(CellState, ListsBothNodesWithTheSameName) {
  CellState cell_state;
  cell_state.receive(device("-", "robot", "a"), 1);
  cell_state.receive(device("-", "robot", "b"), 2);
  EXPECT_EQ(cell_state.devices("robot").size(), 2U);
}

TEST(CellState, KeepsADeviceWhoseKeyChangesWhenItIsDeployed) {
  CellState cell_state;
  cell_state.receive(device("-", "robot", "a"), 1);
  cell_state.receive(device("cell", "robot", "a"), 1);
  cell_state.remove(only_key(device("-", "robot", "a")), 1);
  ASSERT_EQ(cell_state.devices().size(), 1U);
  EXPECT_EQ(cell_state.devices()[0].status.cell(), "cell");
}

TEST(CellState, RemovesADeviceThatDisposesOfItsOnlyKey) {
  CellState cell_state;
  cell_state.receive(device("-", "robot", "a"), 1);
  cell_state.receive(device("-", "robot", "b"), 2);
  cell_state.remove(only_key(device("-", "robot", "a")), 1);
  ASSERT_EQ(cell_state.devices().size(), 1U);
  EXPECT_EQ(cell_state.devices()[0].node(), "b");
}

TEST(CellState, RemovesAnUndeployedModuleAndItsPorts) {
  CellState cell_state;
  cell_state.receive(device("cell", "robot", "a"), 1);
  cell_state.receive(module("servo", STATE_DESTRUCT));
  cell_state.receive(module("arm", STATE_DESTRUCT));
  PortStatus port;
  set(port.cell(), "cell");
  set(port.device(), "robot");
  set(port.name(), "servo");
  set(port.port(), "effort");
  cell_state.receive(port);
  ASSERT_EQ(cell_state.devices()[0].deployment.ports.count("servo.effort"), 1U);
  cell_state.remove(only_key(module("servo", STATE_DESTRUCT)));
  const ObservedDeployment left = cell_state.devices()[0].deployment;
  EXPECT_EQ(left.modules.count("servo"), 0U);
  EXPECT_EQ(left.modules.count("arm"), 1U);
  EXPECT_TRUE(left.ports.empty());
}

TEST(CellState, TellsWhetherAPortDropsSamplesNow) {
  CellState cell_state;
  cell_state.receive(device("cell", "robot", "a"), 1);
  PortStatus status;
  set(status.cell(), "cell");
  set(status.device(), "robot");
  set(status.name(), "servo");
  set(status.port(), "effort");
  std::int64_t now_ns = 0;
  const auto is_dropping = [&](std::uint64_t dropped, std::int64_t seconds) {
    now_ns += seconds * 1'000'000'000;
    status.dropped(dropped);
    status.time_ns(now_ns);
    cell_state.receive(status);
    return cell_state.devices()[0].deployment.ports.at("servo.effort").dropping();
  };
  EXPECT_FALSE(is_dropping(27757, 1)) << "nothing is known about the time of the drops";
  EXPECT_TRUE(is_dropping(27758, 1));
  EXPECT_TRUE(is_dropping(27758, 4));
  EXPECT_FALSE(is_dropping(27758, 1));
}

TEST(CellState, SortsDevicesByName) {
  CellState cell_state;
  cell_state.receive(device("-", "station", "a"), 1);
  cell_state.receive(device("-", "line", "z"), 2);
  cell_state.receive(device("-", "robot", "m"), 3);
  std::vector<std::string> names;
  for (const ObservedDevice& device : cell_state.devices()) names.push_back(device.name());
  EXPECT_THAT(names, testing::ElementsAre("line", "robot", "station"));
}

}  // namespace
}  // namespace takt::wire::cell_state_test
