#include <gmock/gmock.h>

#include <takt/dds/fault.hpp>
#include <takt/dds/words.hpp>
#include <takt/model/json.hpp>

#include "fake_device.hpp"

namespace takt::node::agent_faults_test {
namespace {

using model::FaultKind;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;

class AgentFaultsTest : public testing::Test {
 protected:
  std::vector<std::string> kinds() const {
    std::vector<std::string> kinds;
    for (const FaultEvent& event : device_.said.faults)
      kinds.emplace_back(to_text(dds::from_wire(event).kind));
    return kinds;
  }
  nlohmann::ordered_json log(const std::string& filter = "") {
    dds::WholeCommand command = device_.command(COMMAND_LOG);
    command.data = filter;
    device_.hear(command);
    return device_.data();
  }
  const FaultEvent& newest() const { return device_.said.faults.back(); }

  FakeDevice device_;
};

TEST_F(AgentFaultsTest, ANodeThatEndedInOrderSaysSoAndAnyOtherShowsByThat) {
  const auto record = std::make_shared<FaultRecord>();
  const auto came_up = [&record] {
    FakeDevice device{{}, false, record};
    device.agent.came_up();
    return device.said.faults.back();
  };
  EXPECT_EQ(came_up().kind(), FAULT_NODE_START);
  const FaultEvent again = came_up();
  EXPECT_EQ(again.kind(), FAULT_NODE_RESTART);
  EXPECT_THAT(again.cause().to_string(), HasSubstr("not ended in order; its last event is 1"));
  EXPECT_EQ(again.sequence_number(), 2U);
  {
    FakeDevice device{{}, false, record};
    device.agent.came_up();
    device.agent.goes_down();
    EXPECT_EQ(device.said.faults.back().kind(), FAULT_NODE_END);
  }
  EXPECT_EQ(came_up().kind(), FAULT_NODE_START);
}

TEST_F(AgentFaultsTest, AnEventOfAModuleHasItsDeviceItsCellAndItsTime) {
  device_.become_running();
  EXPECT_EQ(newest().kind(), FAULT_DEPLOYED);
  device_.work.noted({.module = "servo",
                      .kind = FaultKind::error,
                      .error = "budget",
                      .cause = "it took\ntoo long",
                      .attachment = "/tmp/core",
                      .cycle = 12},
                     "");
  const FaultEvent& event = newest();
  EXPECT_EQ(event.path(), "cell/robot");
  EXPECT_EQ(event.name(), "servo");
  EXPECT_EQ(event.kind(), FAULT_ERROR);
  EXPECT_EQ(event.severity(), SEVERITY_ERROR);
  EXPECT_EQ(event.error(), ERROR_BUDGET);
  EXPECT_EQ(event.cause(), "it took\\ntoo long");
  EXPECT_EQ(event.attachment(), "/tmp/core");
  EXPECT_EQ(event.cycle(), 12U);
  EXPECT_EQ(event.count(), 1U);
  EXPECT_EQ(event.sequence_number(), 2U);
  EXPECT_EQ(event.time_ns(), device_.wall());
}

TEST_F(AgentFaultsTest, EveryKindHasItsEnumeratorOnTheWire) {
  for (std::size_t i = 0; i < model::kFaultKinds; ++i) {
    const model::Fault fault{
        .cell = "-", .device = "robot", .kind = static_cast<FaultKind>(i), .error = "stale"};
    EXPECT_EQ(dds::from_wire(dds::to_wire(fault)), fault);
  }
  EXPECT_EQ(static_cast<std::size_t>(FAULT_NOT_REAL_TIME) + 1, model::kFaultKinds);
  EXPECT_EQ(dds::to_wire({.kind = FaultKind::refused_packet}).kind(), FAULT_REFUSED_PACKET);
  EXPECT_EQ(dds::to_wire({.kind = FaultKind::host_restart}).kind(), FAULT_HOST_RESTART);
}

TEST_F(AgentFaultsTest, ARefusedCommandIsAnEvent) {
  device_.hear(device_.command(COMMAND_START));
  EXPECT_EQ(newest().kind(), FAULT_REFUSED_COMMAND);
  EXPECT_EQ(newest().cause(), "start: device robot has no deployment");
  device_.become_running();
  const std::size_t before = device_.said.faults.size();
  dds::WholeCommand stop = device_.command(COMMAND_STOP);
  stop.head.module_name("servo");
  device_.hear(stop);
  EXPECT_EQ(device_.said.faults.size(), before) << "it is under way";
  device_.work.done.back()({.code = REPLY_OK, .state = lifecycle::State::start, .text = ""});
  EXPECT_EQ(newest().kind(), FAULT_COMMAND);
  EXPECT_EQ(newest().name(), "servo");
  EXPECT_EQ(newest().cause(), "stop was carried out");
}

TEST_F(AgentFaultsTest, AFloodOfRefusalsIsOneEventASecondAndExact) {
  for (int i = 0; i < 1000; ++i) {
    dds::WholeCommand start = device_.command(COMMAND_START);
    start.head.id("asker-" + std::to_string(i));
    device_.agent.hear(start);
    device_.pass(milliseconds{10});
  }
  device_.agent.goes_down();
  std::uint64_t refused = 0;
  for (const FaultEvent& event : device_.said.faults)
    refused += event.kind() == FAULT_REFUSED_COMMAND ? event.count() : 0;
  EXPECT_EQ(refused, 1000U);
  EXPECT_LE(device_.said.faults.size(), 13U);
}

TEST_F(AgentFaultsTest, TheLogAnswersWithWhatTheFilterTakes) {
  device_.agent.came_up();
  device_.become_running();
  for (int i = 0; i < 3; ++i) device_.work.noted({.module = "servo", .kind = FaultKind::host_restart}, "");
  const auto all = log();
  EXPECT_EQ(device_.reply().code(), REPLY_OK);
  EXPECT_EQ(all["events"].size(), 5U);
  EXPECT_EQ(all["newest"], 5);
  EXPECT_EQ(all["overwritten"], 0);
  EXPECT_TRUE(all["file"].is_null());
  const auto some = log(R"({"kinds": ["host-restart"], "last": 2})");
  ASSERT_EQ(some["events"].size(), 2U);
  EXPECT_EQ(some["events"][0]["sequence"], 4);
  EXPECT_EQ(log(R"({"after": 4})")["events"].size(), 1U);
  EXPECT_EQ(device_.said.faults.size(), 5U) << "to ask is no event";
}

TEST_F(AgentFaultsTest, AWrongFilterIsRefusedWithWhatWouldBeRight) {
  dds::WholeCommand command = device_.command(COMMAND_LOG);
  command.data = R"({"kinds": ["eror"]})";
  device_.hear(command);
  EXPECT_EQ(device_.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device_.text(), HasSubstr("did you mean error"));
}

TEST_F(AgentFaultsTest, TheEndOfADeploymentLeavesNoCountBehind) {
  device_.become_running();
  for (int i = 0; i < 5; ++i)
    device_.work.noted({.module = "servo", .kind = FaultKind::overrun, .count = 2}, "");
  device_.undeploy();
  device_.end();
  EXPECT_THAT(kinds(), ElementsAre("deployed", "overrun", "overrun", "undeployed"));
  EXPECT_EQ(device_.said.faults[1].count() + device_.said.faults[2].count(), 10U);
  EXPECT_EQ(newest().cell(), "cell");
}

TEST_F(AgentFaultsTest, ADeviceOfTheCellThatIsLostIsAnEventOfEachThatSeesIt) {
  DeviceStatus line;
  dds::set(line.path(), "cell/line");
  dds::set(line.cell(), "cell");
  dds::set(line.device(), "line");
  dds::set(line.node(), "there");
  device_.agent.others().heard(line, 5);
  device_.become_running();
  device_.pass(milliseconds{10});
  device_.agent.others().lost(5);
  device_.pass(milliseconds{10});
  EXPECT_EQ(newest().kind(), FAULT_DEVICE_LOST);
  EXPECT_THAT(newest().cause().to_string(), HasSubstr("device line is lost"));
  EXPECT_THAT(log()["lost"], ElementsAre("line"));
  device_.agent.others().heard(line, 5);
  device_.pass(milliseconds{10});
  EXPECT_EQ(newest().kind(), FAULT_DEVICE_BACK);
}

}  // namespace
}  // namespace takt::node::agent_faults_test
