#include <gmock/gmock.h>

#include <takt/model/json.hpp>
#include <takt/wire/fault.hpp>
#include <takt/wire/words.hpp>

#include "fake_device.hpp"

namespace takt::agent::agent_alarms_test {
namespace {

using model::FaultKind;
using std::chrono::milliseconds;
using testing::HasSubstr;
using testing::SizeIs;

std::vector<model::Alarm> alarms_of(FakeDevice& device) {
  device.receive(device.command(COMMAND_ALARMS));
  return model::alarms_from(device.data()).value();
}

wire::WholeCommand acknowledge(FakeDevice& device, const std::string& module, const std::string& data) {
  wire::WholeCommand command = device.command(COMMAND_ACKNOWLEDGE);
  command.head.module_name(module.c_str());
  command.head.value("anna@pc7");
  command.data = data;
  return command;
}

class AgentWithAlarms : public testing::Test {
 protected:
  void fails(const std::string& module, lifecycle::State to = lifecycle::State::recover) {
    device_.work.noted({.module = module, .kind = FaultKind::error, .error = "failure", .cause = "boom"}, "");
    step(to);
  }
  void step(lifecycle::State to) {
    device_.work.stepped({.module = 0,
                          .transition = {.from = lifecycle::State::executing,
                                         .to = to,
                                         .event = lifecycle::Event::error,
                                         .sequence = ++sequence_}});
    device_.pass(milliseconds{10});
  }
  [[nodiscard]] std::uint32_t unacknowledged() const {
    return device_.published.devices.back().unacknowledged_alarms();
  }

  FakeDevice device_;
  std::uint64_t sequence_ = 10;
};

TEST_F(AgentWithAlarms, PublishesTheirNumberAndEachChange) {
  device_.become_running();
  EXPECT_EQ(unacknowledged(), 0U);
  const auto before = device_.published.devices.back().alarm_changes();
  fails("servo");
  EXPECT_EQ(unacknowledged(), 1U);
  EXPECT_GT(device_.published.devices.back().alarm_changes(), before);
  device_.receive(acknowledge(device_, "servo", R"({"note": "the cable"})"));
  EXPECT_EQ(device_.reply().code(), REPLY_OK);
  device_.pass(milliseconds{10});
  EXPECT_EQ(unacknowledged(), 0U);
}

TEST_F(AgentWithAlarms, KeepsTheAlarmOfAModuleThatHasRecovered) {
  device_.become_running();
  fails("servo");
  EXPECT_TRUE(alarms_of(device_).at(0).active);
  step(lifecycle::State::executing);
  EXPECT_FALSE(alarms_of(device_).at(0).active);
  EXPECT_EQ(unacknowledged(), 1U);
}

TEST_F(AgentWithAlarms, RecordsTheOperatorAndTheNoteOfAnAcknowledgement) {
  device_.become_running();
  fails("servo");
  device_.receive(acknowledge(device_, "servo", R"({"note": "a\nb"})"));
  const FaultEvent& event = device_.published.faults.back();
  EXPECT_EQ(event.kind(), FAULT_ACKNOWLEDGED);
  EXPECT_EQ(event.name(), "servo");
  EXPECT_EQ(event.cause(), "alarm 2 (error) acknowledged by anna@pc7: a\\nb");
  const auto alarm = alarms_of(device_).at(0);
  EXPECT_EQ(alarm.acknowledged->by, "anna@pc7");
  EXPECT_EQ(alarm.acknowledged->note, "a\\nb");
}

TEST_F(AgentWithAlarms, TakesTheNameFromTheCertificateIfThereIsOne) {
  device_.become_running();
  fails("servo");
  auto command = acknowledge(device_, "", "{}");
  command.who = "operator anna at 10.0.0.7";
  device_.receive(command);
  EXPECT_EQ(alarms_of(device_).at(0).acknowledged->by, "operator anna at 10.0.0.7");
}

TEST_F(AgentWithAlarms, WritesTheNameThatAClientGivesWithoutAColon) {
  device_.become_running();
  fails("servo");
  auto command = acknowledge(device_, "", R"({"note": "seen"})");
  command.head.value("anna: otto");
  device_.receive(command);
  EXPECT_EQ(alarms_of(device_).at(0).acknowledged->by, "anna_ otto");
  EXPECT_EQ(alarms_of(device_).at(0).acknowledged->note, "seen");
}

TEST_F(AgentWithAlarms, RejectsAnAcknowledgementIfThereIsNoAlarm) {
  device_.become_running();
  device_.receive(acknowledge(device_, "servo", "{}"));
  EXPECT_EQ(device_.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(device_.text(), "module robot.servo has no unacknowledged alarm; takt alarms lists all alarms");
  fails("servo");
  device_.receive(acknowledge(device_, "servo", R"({"alarm": 1})"));
  EXPECT_THAT(device_.text(), HasSubstr("has no unacknowledged alarm 1;"));
  EXPECT_EQ(unacknowledged(), 1U);
}

TEST_F(AgentWithAlarms, RejectsATooLongNote) {
  device_.become_running();
  fails("servo");
  const std::string note(256, 'x');
  device_.receive(acknowledge(device_, "servo", R"({"note": ")" + note + R"("})"));
  EXPECT_EQ(device_.reply().code(), REPLY_REFUSED);
  EXPECT_EQ(unacknowledged(), 1U);
  EXPECT_THAT(device_.published.faults.back().cause().to_string(),
              HasSubstr("acknowledge: the acknowledgement is not valid: the note has 256 bytes"));
}

TEST(AgentAfterARestart, StillHasTheAlarms) {
  const auto record = std::make_shared<node::FaultRecord>();
  {
    FakeDevice device{{}, false, record};
    device.agent.note_start();
    device.become_running();
    device.work.noted({.module = "servo", .kind = FaultKind::given_up, .cause = "boom"}, "");
    device.work.noted({.module = "arm", .kind = FaultKind::host_restart, .cause = "its host ended"}, "");
    device.receive(acknowledge(device, "arm", "{}"));
    EXPECT_THAT(alarms_of(device), SizeIs(1));
  }
  FakeDevice device{{}, false, record};
  device.agent.note_start();
  device.pass(milliseconds{10});
  const auto alarms = alarms_of(device);
  ASSERT_THAT(alarms, SizeIs(2)) << "the previous node did not shut down cleanly";
  EXPECT_EQ(alarms[0].module, "servo");
  EXPECT_FALSE(alarms[0].active);
  EXPECT_EQ(alarms[1].kind, FaultKind::node_restart);
  EXPECT_EQ(device.published.devices.back().unacknowledged_alarms(), 2U);
}

TEST(AgentAfterARestart, EndsTheAlarmOfALostDeviceAfterItsRemovalFromTheCell) {
  const auto record = std::make_shared<node::FaultRecord>();
  for (const std::string name : {"line", "former"}) {
    model::Fault lost{.cell = "cell",
                      .device = "robot",
                      .kind = FaultKind::device_lost,
                      .cause = "device " + name + " is lost: nothing arrives from its node"};
    record->append(lost);
  }
  FakeDevice device{{}, false, record};
  device.agent.note_start();
  device.become_running();
  device.pass(milliseconds{10});
  for (const model::Alarm& alarm : alarms_of(device)) {
    if (alarm.kind != FaultKind::device_lost) continue;
    EXPECT_EQ(alarm.active, alarm.cause.find("former") == std::string::npos) << alarm.cause;
  }
}

TEST(AgentAfterARestart, EndsTheAlarmOfALostDeviceAfterItsReturn) {
  const auto record = std::make_shared<node::FaultRecord>();
  model::Fault lost{.cell = "cell",
                    .device = "robot",
                    .kind = FaultKind::device_lost,
                    .cause = "device line is lost: nothing arrives from its node"};
  record->append(lost);
  FakeDevice device{{}, false, record};
  device.agent.note_start();
  DeviceStatus line;
  wire::set(line.path(), "cell/line");
  wire::set(line.cell(), "cell");
  wire::set(line.device(), "line");
  wire::set(line.node(), "there");
  device.agent.others().receive(line, 5);
  device.become_running();
  device.pass(milliseconds{10});
  for (const model::Alarm& alarm : alarms_of(device)) EXPECT_FALSE(alarm.active) << alarm.cause;
}

}  // namespace
}  // namespace takt::agent::agent_alarms_test
