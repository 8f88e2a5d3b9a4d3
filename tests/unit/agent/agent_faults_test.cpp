#include <gmock/gmock.h>

#include <takt/model/json.hpp>
#include <takt/wire/fault.hpp>
#include <takt/wire/words.hpp>

#include "fake_device.hpp"

namespace takt::agent::agent_faults_test {
namespace {

using model::FaultKind;
using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::ElementsAre;
using testing::HasSubstr;

class AgentRecordingFaults : public testing::Test {
 protected:
  std::vector<std::string> kinds() const {
    std::vector<std::string> kinds;
    for (const FaultEvent& event : device_.published.faults)
      kinds.emplace_back(to_text(wire::from_wire(event).kind));
    return kinds;
  }
  nlohmann::ordered_json log(const std::string& filter = "") {
    wire::WholeCommand command = device_.command(COMMAND_LOG);
    command.data = filter;
    device_.receive(command);
    return device_.data();
  }
  const FaultEvent& newest() const { return device_.published.faults.back(); }

  FakeDevice device_;
};

TEST_F(AgentRecordingFaults, DetectsACrashOfThePreviousNode) {
  const auto record = std::make_shared<node::FaultRecord>();
  const auto note_start = [&record] {
    FakeDevice device{{}, false, record};
    device.agent.note_start();
    return device.published.faults.back();
  };
  EXPECT_EQ(note_start().kind(), FAULT_NODE_START);
  const FaultEvent again = note_start();
  EXPECT_EQ(again.kind(), FAULT_NODE_RESTART);
  EXPECT_THAT(again.cause().to_string(), HasSubstr("did not shut down cleanly; its last event is number 1"));
  EXPECT_EQ(again.sequence_number(), 2U);
  {
    FakeDevice device{{}, false, record};
    device.agent.note_start();
    device.agent.note_end();
    EXPECT_EQ(device.published.faults.back().kind(), FAULT_NODE_END);
  }
  EXPECT_EQ(note_start().kind(), FAULT_NODE_START);
}

TEST_F(AgentRecordingFaults, AddsDeviceCellAndTimeToAnEventOfAModule) {
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

// The agent reads the wall clock and the monotonic clock one after the other. So the difference that it
// measures varies from event to event.
TEST_F(AgentRecordingFaults, KeepsTheOrderOfLogLinesThatOneRunHasWritten) {
  device_.become_running();
  const std::int64_t run_ns = to_ns(device_.now);
  for (const int late : {300, 100, 200}) {
    device_.set = Nanoseconds{late};
    device_.work.noted({.time_ns = run_ns, .module = "servo", .kind = FaultKind::log_info, .cause = "a line"},
                       "");
  }
  const auto& events = device_.published.faults;
  ASSERT_GE(events.size(), 3U);
  for (std::size_t i = events.size() - 2; i < events.size(); ++i)
    EXPECT_GE(events[i].time_ns(), events[i - 1].time_ns());
  device_.set = seconds{3600};
  device_.work.noted({.time_ns = run_ns, .module = "servo", .kind = FaultKind::log_info, .cause = "later"},
                     "");
  EXPECT_EQ(newest().time_ns(), device_.wall());
}

TEST_F(AgentRecordingFaults, ConvertsEveryFaultKindToDdsAndBack) {
  for (std::size_t i = 0; i < model::kFaultKinds; ++i) {
    const model::Fault fault{
        .cell = "-", .device = "robot", .kind = static_cast<FaultKind>(i), .error = "stale"};
    EXPECT_EQ(wire::from_wire(wire::to_wire(fault)), fault);
  }
  EXPECT_EQ(static_cast<std::size_t>(FAULT_ACKNOWLEDGED) + 1, model::kFaultKinds);
  EXPECT_EQ(wire::to_wire({.kind = FaultKind::refused_packet}).kind(), FAULT_REFUSED_PACKET);
  EXPECT_EQ(wire::to_wire({.kind = FaultKind::host_restart}).kind(), FAULT_HOST_RESTART);
}

TEST_F(AgentRecordingFaults, RecordsRejectedAndCompletedCommands) {
  device_.receive(device_.command(COMMAND_START));
  EXPECT_EQ(newest().kind(), FAULT_REFUSED_COMMAND);
  EXPECT_EQ(newest().cause(),
            "start: device robot has no deployment; deploy a cell to it first: takt deploy CELL");
  device_.become_running();
  const std::size_t before = device_.published.faults.size();
  wire::WholeCommand stop = device_.command(COMMAND_STOP);
  stop.head.module_name("servo");
  device_.receive(stop);
  EXPECT_EQ(device_.published.faults.size(), before) << "the command is still in progress";
  device_.work.done.back()({.code = REPLY_OK, .state = lifecycle::State::start, .text = ""});
  EXPECT_EQ(newest().kind(), FAULT_COMMAND);
  EXPECT_EQ(newest().name(), "servo");
  EXPECT_EQ(newest().cause(), "stop was carried out");

  wire::WholeCommand recover = device_.command(COMMAND_RECOVER);
  recover.head.module_name("servo");
  device_.receive(recover);
  const std::string why = "recover is not allowed in state START; it is allowed in RECOVER";
  device_.work.done.back()({.code = REPLY_REFUSED, .state = lifecycle::State::start, .text = why});
  EXPECT_EQ(newest().cause(), why) << "the command must not be named twice";
}

TEST_F(AgentRecordingFaults, DoesNotRecordARejectedQuestion) {
  device_.become_running();
  const std::size_t before = device_.published.faults.size();
  wire::WholeCommand tap = device_.command(COMMAND_TAP);
  tap.head.module_name("no_such_module");
  device_.receive(tap);
  EXPECT_EQ(device_.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device_.published.faults.size(), before);
}

TEST_F(AgentRecordingFaults, MergesRejectedCommandsIntoOneCountedEventPerSecond) {
  for (int i = 0; i < 1000; ++i) {
    wire::WholeCommand start = device_.command(COMMAND_START);
    start.head.id("asker-" + std::to_string(i));
    device_.agent.receive(start);
    device_.pass(milliseconds{10});
  }
  device_.agent.note_end();
  std::uint64_t refused = 0;
  for (const FaultEvent& event : device_.published.faults)
    refused += event.kind() == FAULT_REFUSED_COMMAND ? event.count() : 0;
  EXPECT_EQ(refused, 1000U);
  EXPECT_LE(device_.published.faults.size(), 13U);
}

TEST_F(AgentRecordingFaults, AnswersALogCommandWithTheFilteredEvents) {
  device_.agent.note_start();
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
  EXPECT_EQ(device_.published.faults.size(), 5U) << "a log command is not an event";
}

TEST_F(AgentRecordingFaults, RejectsAnInvalidLogFilterWithASuggestion) {
  wire::WholeCommand command = device_.command(COMMAND_LOG);
  command.data = R"({"kinds": ["eror"]})";
  device_.receive(command);
  EXPECT_EQ(device_.reply().code(), REPLY_REFUSED);
  EXPECT_THAT(device_.text(), HasSubstr("did you mean error"));
}

TEST_F(AgentRecordingFaults, EmitsPendingEventCountsAtTheEndOfADeployment) {
  device_.become_running();
  for (int i = 0; i < 5; ++i)
    device_.work.noted({.module = "servo", .kind = FaultKind::overrun, .count = 2}, "");
  device_.undeploy();
  device_.end();
  EXPECT_THAT(kinds(), ElementsAre("deployed", "overrun", "overrun", "undeployed"));
  EXPECT_EQ(device_.published.faults[1].count() + device_.published.faults[2].count(), 10U);
  EXPECT_EQ(newest().cell(), "cell");
}

TEST_F(AgentRecordingFaults, RecordsTheLossAndReturnOfAnotherDevice) {
  DeviceStatus line;
  wire::set(line.path(), "cell/line");
  wire::set(line.cell(), "cell");
  wire::set(line.device(), "line");
  wire::set(line.node(), "there");
  device_.agent.others().receive(line, 5);
  device_.become_running();
  device_.pass(milliseconds{10});
  device_.agent.others().lost(5);
  device_.pass(milliseconds{10});
  EXPECT_EQ(newest().kind(), FAULT_DEVICE_LOST);
  EXPECT_EQ(newest().cause(), "device line is lost: nothing arrives from its node");
  EXPECT_EQ(device_.logged.back(), "device line is lost: nothing arrives from its node");
  EXPECT_THAT(log()["lost"], ElementsAre("line"));
  device_.agent.others().receive(line, 5);
  device_.pass(milliseconds{10});
  EXPECT_EQ(newest().kind(), FAULT_DEVICE_BACK);
  device_.agent.others().lost(5);
  device_.pass(seconds{6});
  EXPECT_EQ(newest().cause(),
            "device line is lost: nothing arrives from its node; this node did not run for 6 s");
}

}  // namespace
}  // namespace takt::agent::agent_faults_test
