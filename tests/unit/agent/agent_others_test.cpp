#include <takt/agent/agent.hpp>

#include <gmock/gmock.h>

#include <takt/wire/words.hpp>

#include "fake_device.hpp"

namespace takt::agent::agent_others_test {
namespace {

using testing::HasSubstr;

DeviceStatus other(const std::string& device, const std::string& node) {
  DeviceStatus status;
  wire::set(status.path(), "-/" + device);
  wire::set(status.cell(), wire::kNoCell);
  wire::set(status.device(), device);
  wire::set(status.node(), node);
  wire::set(status.host_name(), "elsewhere");
  status.process_id(42);
  return status;
}

TEST(AgentWithOtherNodes, RejectsDeploymentsWhileAnotherNodeUsesTheSameName) {
  FakeDevice device;
  device.agent.others().receive(other("robot", "there"), 1);
  device.agent.step();
  EXPECT_EQ(device.status().health(), HEALTH_DEGRADED);
  EXPECT_EQ(device.status().text(), "another node named robot is on domain 7: process 42 on elsewhere");
  device.prepare();
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("2 nodes on domain 7 have this name: process "));
  EXPECT_THAT(device.text(), HasSubstr(", process 42 on elsewhere; end all but one of them"));
  device.agent.others().lost(1);
  device.agent.step();
  EXPECT_EQ(device.status().health(), HEALTH_OK);
  device.prepare();
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
}

TEST(AgentWithOtherNodes, UndoesADeploymentThatAnotherNodeOfItsNameExecutesBeforeT0) {
  for (const bool starting : {false, true}) {
    FakeDevice device;
    if (starting)
      device.become_ready();
    else
      device.prepare();
    device.published.replies.clear();
    DeviceStatus twin = other("robot", "there");
    twin.state(DEVICE_RUNNING);
    device.agent.others().receive(twin, 1);
    device.agent.step();
    EXPECT_EQ(device.work.stop_called, starting);
    if (starting) device.end();
    EXPECT_EQ(device.status().state(), DEVICE_WAITING);
    EXPECT_EQ(device.status().stage(), STAGE_UNDONE);
    EXPECT_FALSE(device.agent.ended());
    if (starting) continue;
    EXPECT_THAT(device.text(), HasSubstr("another node named robot is on domain 7"));
  }
}

TEST(AgentWithOtherNodes, RejectsCommandsToItsNameWhileAnotherNodeUsesIt) {
  FakeDevice device;
  device.become_running();
  device.agent.others().receive(other("robot", "there"), 1);
  device.agent.step();
  for (const CommandKind kind :
       {COMMAND_INITIALIZE, COMMAND_START, COMMAND_STOP, COMMAND_RECOVER, COMMAND_RESET, COMMAND_DESTRUCT,
        COMMAND_SET, COMMAND_SWAP, COMMAND_PREPARE, COMMAND_UNDEPLOY, COMMAND_GET, COMMAND_DESCRIBE,
        COMMAND_DESCRIPTOR, COMMAND_TAP, COMMAND_TRACE, COMMAND_LOG, COMMAND_ALARMS, COMMAND_ACKNOWLEDGE}) {
    device.receive(device.command(kind));
    EXPECT_EQ(device.reply().code(), REPLY_REFUSED) << to_text(kind);
    EXPECT_THAT(device.text(), HasSubstr("2 nodes on domain 7 have this name: ")) << to_text(kind);
  }
  EXPECT_EQ(device.status().state(), DEVICE_RUNNING);
}

TEST(AgentWithOtherNodes, ShowsTheNameConflictInItsReport) {
  FakeDevice device;
  device.become_running();
  device.agent.others().receive(other("robot", "there"), 1);
  device.agent.step();
  device.receive(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.reply().code(), REPLY_OK);
  EXPECT_EQ(device.data()["conflict"], "another node named robot is on domain 7: process 42 on elsewhere");
  EXPECT_FALSE(device.data().contains("text")) << "the conflict is reported once";
}

TEST(AgentWithOtherNodes, UndeploysItsOwnDeploymentDuringANameConflict) {
  FakeDevice device;
  device.become_running();
  device.agent.others().receive(other("robot", "there"), 1);
  device.agent.step();
  device.undeploy("d1");
  EXPECT_TRUE(device.work.stop_called);
}

TEST(AgentWithOtherNodes, ReportsNoNameConflictWithItselfOrOtherDevices) {
  FakeDevice device;
  device.agent.others().receive(other("robot", "here"), 1);
  device.agent.others().receive(other("line", "there"), 2);
  device.agent.step();
  EXPECT_EQ(device.status().health(), HEALTH_OK);
}

TEST(AgentWithOtherNodes, ListsTheOtherLiveNodesInItsReport) {
  FakeDevice device;
  device.agent.others().receive(other("robot", "here"), 1);
  device.agent.others().receive(other("line", "there"), 2);
  device.agent.others().receive(other("line", "twin"), 3);
  device.receive(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["heard"], (nlohmann::ordered_json{"there", "twin", "here"}));
  device.agent.others().lost(2);
  device.receive(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["heard"], (nlohmann::ordered_json{"twin", "here"}));
}

TEST(AgentWithOtherNodes, ReportsDuringItsFirstSecondThatItStillSearchesForNodes) {
  FakeDevice device;
  device.receive(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["searching"], true);
  device.now += std::chrono::milliseconds{1001};
  device.receive(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["searching"], false);
}

TEST(AgentWithOtherNodes, ListsLostDevicesOfItsCellInItsReport) {
  FakeDevice device;
  device.become_running();
  DeviceStatus line = other("line", "there");
  wire::set(line.path(), "cell/line");
  wire::set(line.cell(), "cell");
  device.agent.others().receive(line, 3);
  LifecycleStatus belt;
  wire::set(belt.path(), "cell/line/belt");
  wire::set(belt.cell(), "cell");
  wire::set(belt.device(), "line");
  wire::set(belt.name(), "belt");
  belt.state(STATE_EXECUTING);
  device.agent.others().receive(belt);
  device.receive(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["lost"].size(), 0U);
  EXPECT_EQ(device.data()["devices"].size(), 2U);
  EXPECT_FALSE(device.work.is_lost("line"));
  device.agent.others().lost(3);
  device.receive(device.command(COMMAND_REPORT));
  ASSERT_EQ(device.data()["lost"].size(), 1U);
  EXPECT_EQ(device.data()["lost"][0]["name"], "line");
  EXPECT_EQ(device.data()["lost"][0]["modules"][0]["state"], "EXECUTING");
  EXPECT_TRUE(device.work.is_lost("line")) << "the supervisor judges the connections";
  device.agent.others().receive(other("robot", "a former node of this device"), 4);
  device.agent.others().lost(4);
  EXPECT_FALSE(device.work.is_lost("robot")) << "this device itself";
}

// Returns the descriptor of a cell that stops if `module` fails.
std::string cell_stopped_by(const std::string& module) {
  std::string text = FakeDevice::kCell;
  const std::size_t at = text.find("</priority>", text.find("<name>" + module + "<"));
  return text.insert(at + std::string{"</priority>"}.size(), R"(<recovery then="stop-cell"/>)");
}

DeviceStatus runs_with_us(const std::string& device, const std::string& node) {
  DeviceStatus status = other(device, node);
  wire::set(status.path(), "cell/" + device);
  wire::set(status.cell(), "cell");
  wire::set(status.deployment(), "d1");
  wire::set(status.transaction(), "d1");
  status.state(DEVICE_RUNNING);
  return status;
}

TEST(AgentWithOtherNodes, StopsWhenAnotherDeviceStopsTheCell) {
  FakeDevice device;
  device.become_running();
  DeviceStatus line = runs_with_us("line", "there");
  device.agent.others().receive(line, 3);
  device.agent.step();
  EXPECT_FALSE(device.work.stop_called);
  line.state(DEVICE_STOPPING);
  line.health(HEALTH_FAILED);
  line.stops_cell(true);
  wire::set(line.text(), "module line.belt: error: it was given up");
  device.agent.others().receive(line, 3);
  device.agent.step();
  EXPECT_TRUE(device.work.stop_called);
  ASSERT_EQ(device.work.failures.size(), 1U);
  EXPECT_EQ(device.work.failures[0].where, "device robot");
  EXPECT_EQ(device.work.failures[0].what, "stops with its cell: module line.belt: error: it was given up");
  EXPECT_TRUE(device.status().stops_cell())
      << "so that devices which do not receive the status of line stop too";
}

TEST(AgentWithOtherNodes, KeepsRunningWhenACellOfAnotherDeploymentStops) {
  FakeDevice device;
  device.become_running();
  DeviceStatus line = runs_with_us("line", "there");
  wire::set(line.deployment(), "d0");
  wire::set(line.transaction(), "d0");
  line.stops_cell(true);
  device.agent.others().receive(line, 3);
  device.agent.step();
  EXPECT_FALSE(device.work.stop_called);
}

TEST(AgentWithOtherNodes, StopsIfALostDeviceHasAModuleWhoseFailureStopsTheCell) {
  for (const bool vital : {false, true}) {
    FakeDevice device;
    device.become_running(vital ? cell_stopped_by("belt") : FakeDevice::kCell);
    device.agent.others().receive(runs_with_us("line", "there"), 3);
    device.agent.step();
    device.agent.others().lost(3);
    device.agent.step();
    EXPECT_EQ(device.work.stop_called, vital);
  }
}

TEST(AgentWithOtherNodes, KeepsRunningWhenAnotherDeviceShutsDownCleanly) {
  FakeDevice device;
  device.become_running(cell_stopped_by("belt"));
  DeviceStatus line = runs_with_us("line", "there");
  device.agent.others().receive(line, 3);
  line.state(DEVICE_STOPPING);
  device.agent.others().receive(line, 3);
  device.agent.others().lost(3);  // the agent learns of the loss before the device disposes of its status
  device.agent.step();
  EXPECT_FALSE(device.work.stop_called);
  device.agent.others().receive(runs_with_us("line", "again"), 4);
  device.agent.others().remove(runs_with_us("line", "again"), 4);
  device.agent.others().lost(4);
  device.agent.step();
  EXPECT_FALSE(device.work.stop_called);
}

TEST(AgentWithOtherNodes, StopsIfAllOtherDevicesAreLostAndItHasAModuleWhoseFailureStopsTheCell) {
  for (const bool vital : {false, true}) {
    FakeDevice device;
    device.become_running(vital ? cell_stopped_by("servo") : FakeDevice::kCell);
    device.agent.others().receive(runs_with_us("line", "there"), 3);
    device.agent.others().receive(runs_with_us("station", "there too"), 4);
    device.agent.others().lost(3);
    device.agent.step();
    EXPECT_FALSE(device.work.stop_called) << "the station is still there";
    device.agent.others().lost(4);
    device.agent.step();
    EXPECT_EQ(device.work.stop_called, vital);
    if (!vital) continue;
    EXPECT_EQ(device.work.failures[0].what,
              "has lost line, station, and one of its modules stops the cell when it fails");
  }
}

}  // namespace
}  // namespace takt::agent::agent_others_test
