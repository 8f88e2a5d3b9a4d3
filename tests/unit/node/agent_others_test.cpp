#include "agent.hpp"

#include <gmock/gmock.h>

#include <takt/dds/words.hpp>

#include "fake_device.hpp"

namespace takt::node::agent_others_test {
namespace {

using testing::HasSubstr;

DeviceStatus other(const std::string& device, const std::string& node) {
  DeviceStatus status;
  dds::set(status.path(), "-/" + device);
  dds::set(status.cell(), dds::kNoCell);
  dds::set(status.device(), device);
  dds::set(status.node(), node);
  dds::set(status.host_name(), "elsewhere");
  status.process_id(42);
  return status;
}

TEST(AgentAndOthers, TwoNodesOfOneNameSaySoAndTakeNothing) {
  FakeDevice device;
  device.agent.others().heard(other("robot", "there"), 1);
  device.agent.step();
  EXPECT_EQ(device.status().health(), HEALTH_DEGRADED);
  EXPECT_EQ(device.status().text(), "another node of the name robot is on domain 7: process 42 on elsewhere");
  device.prepare();
  EXPECT_EQ(device.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device.text(), HasSubstr("another node of the name robot"));
  device.agent.others().lost(1);
  device.agent.step();
  EXPECT_EQ(device.status().health(), HEALTH_OK);
  device.prepare();
  EXPECT_EQ(device.status().state(), DEVICE_PREPARING);
}

TEST(AgentAndOthers, ItselfAndOtherDevicesAreNoOthersOfItsName) {
  FakeDevice device;
  device.agent.others().heard(other("robot", "here"), 1);
  device.agent.others().heard(other("line", "there"), 2);
  device.agent.step();
  EXPECT_EQ(device.status().health(), HEALTH_OK);
}

TEST(AgentAndOthers, NamesTheLiveNodesThatItHearsInItsReport) {
  FakeDevice device;
  device.agent.others().heard(other("robot", "here"), 1);
  device.agent.others().heard(other("line", "there"), 2);
  device.agent.others().heard(other("line", "twin"), 3);
  device.hear(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["heard"], (nlohmann::ordered_json{"there", "twin", "here"}));
  device.agent.others().lost(2);
  device.hear(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["heard"], (nlohmann::ordered_json{"twin", "here"}));
}

TEST(AgentAndOthers, SaysForASecondThatItMayNotKnowTheOthersYet) {
  FakeDevice device;
  device.hear(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["searching"], true);
  device.now += std::chrono::milliseconds{1001};
  device.hear(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["searching"], false);
}

TEST(AgentAndOthers, LostDevicesOfItsCellAreInItsReport) {
  FakeDevice device;
  device.become_running();
  DeviceStatus line = other("line", "there");
  dds::set(line.path(), "cell/line");
  dds::set(line.cell(), "cell");
  device.agent.others().heard(line, 3);
  LifecycleStatus belt;
  dds::set(belt.path(), "cell/line/belt");
  dds::set(belt.cell(), "cell");
  dds::set(belt.device(), "line");
  dds::set(belt.name(), "belt");
  belt.state(STATE_EXECUTING);
  device.agent.others().heard(belt);
  device.hear(device.command(COMMAND_REPORT));
  EXPECT_EQ(device.data()["lost"].size(), 0U);
  EXPECT_EQ(device.data()["devices"].size(), 2U);
  device.agent.others().lost(3);
  device.hear(device.command(COMMAND_REPORT));
  ASSERT_EQ(device.data()["lost"].size(), 1U);
  EXPECT_EQ(device.data()["lost"][0]["name"], "line");
  EXPECT_EQ(device.data()["lost"][0]["modules"][0]["state"], "EXECUTING");
}

// A cell in which a fault of the line, or of the robot, is everybody's.
std::string cell_stopped_by(const std::string& module) {
  std::string text = FakeDevice::kCell;
  const std::size_t at = text.find("</priority>", text.find("<name>" + module + "<"));
  return text.insert(at + std::string{"</priority>"}.size(), R"(<recovery then="stop-cell"/>)");
}

DeviceStatus runs_with_us(const std::string& device, const std::string& node) {
  DeviceStatus status = other(device, node);
  dds::set(status.path(), "cell/" + device);
  dds::set(status.cell(), "cell");
  dds::set(status.deployment(), "d1");
  status.state(DEVICE_RUNNING);
  return status;
}

TEST(AgentAndOthers, StopsWithItsCellWhenAnotherDeviceSaysSo) {
  FakeDevice device;
  device.become_running();
  DeviceStatus line = runs_with_us("line", "there");
  device.agent.others().heard(line, 3);
  device.agent.step();
  EXPECT_FALSE(device.work.told_to_stop);
  line.state(DEVICE_STOPPING);
  line.health(HEALTH_FAILED);
  line.stops_cell(true);
  dds::set(line.text(), "module line.belt: error: was given up");
  device.agent.others().heard(line, 3);
  device.agent.step();
  EXPECT_TRUE(device.work.told_to_stop);
  ASSERT_EQ(device.work.failures.size(), 1U);
  EXPECT_EQ(device.work.failures[0].where, "device robot");
  EXPECT_EQ(device.work.failures[0].what, "stops with its cell: module line.belt: error: was given up");
  EXPECT_TRUE(device.status().stops_cell()) << "for who does not hear the line";
}

TEST(AgentAndOthers, TheCellOfAnotherDeploymentIsNotItsOwn) {
  FakeDevice device;
  device.become_running();
  DeviceStatus line = runs_with_us("line", "there");
  dds::set(line.deployment(), "d0");
  line.stops_cell(true);
  device.agent.others().heard(line, 3);
  device.agent.step();
  EXPECT_FALSE(device.work.told_to_stop);
}

TEST(AgentAndOthers, StopsWhenADeviceWhoseFaultIsTheCellsIsLost) {
  for (const bool vital : {false, true}) {
    FakeDevice device;
    device.become_running(vital ? cell_stopped_by("belt") : FakeDevice::kCell);
    device.agent.others().heard(runs_with_us("line", "there"), 3);
    device.agent.step();
    device.agent.others().lost(3);
    device.agent.step();
    EXPECT_EQ(device.work.told_to_stop, vital);
  }
}

TEST(AgentAndOthers, AnOrderlyEndOfAnotherDeviceIsNoFault) {
  FakeDevice device;
  device.become_running(cell_stopped_by("belt"));
  DeviceStatus line = runs_with_us("line", "there");
  device.agent.others().heard(line, 3);
  line.state(DEVICE_STOPPING);
  device.agent.others().heard(line, 3);
  device.agent.others().lost(3);  // it was quicker than what it took back
  device.agent.step();
  EXPECT_FALSE(device.work.told_to_stop);
  device.agent.others().heard(runs_with_us("line", "again"), 4);
  device.agent.others().gone(runs_with_us("line", "again"), 4);
  device.agent.others().lost(4);
  device.agent.step();
  EXPECT_FALSE(device.work.told_to_stop);
}

TEST(AgentAndOthers, StopsWhenItsOwnFaultCouldNotBeToldToAnybody) {
  for (const bool vital : {false, true}) {
    FakeDevice device;
    device.become_running(vital ? cell_stopped_by("servo") : FakeDevice::kCell);
    device.agent.others().heard(runs_with_us("line", "there"), 3);
    device.agent.others().heard(runs_with_us("station", "there too"), 4);
    device.agent.others().lost(3);
    device.agent.step();
    EXPECT_FALSE(device.work.told_to_stop) << "the station is there to hear it";
    device.agent.others().lost(4);
    device.agent.step();
    EXPECT_EQ(device.work.told_to_stop, vital);
    if (!vital) continue;
    EXPECT_EQ(device.work.failures[0].what,
              "has lost line, station, and has a module whose fault stops the cell");
  }
}

}  // namespace
}  // namespace takt::node::agent_others_test
