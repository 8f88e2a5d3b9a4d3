#include <takt/agent/agent.hpp>

#include <gmock/gmock.h>

#include "fake_device.hpp"

namespace takt::agent::agent_clocks_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::StartsWith;
using Phase = Supervised::Phase;

/// Prepares a deployment and lets it continue until every module is in START.
void prepare(FakeDevice& device) {
  device.begin();
  device.work.phase = Phase::ready;
  device.published.replies.clear();
}

std::vector<std::string> kinds(const FakeDevice& device) {
  std::vector<std::string> words;
  for (const FaultEvent& event : device.published.faults)
    words.emplace_back(model::to_text(static_cast<model::FaultKind>(event.kind())));
  return words;
}

TEST(AgentClocks, RejectsADeploymentIfTheClockOfAnotherDeviceDiffersTooMuch) {
  for (const seconds ahead : {seconds{30}, seconds{-30}}) {
    FakeDevice device;
    device.line_ahead = ahead;
    prepare(device);
    device.hear_line(DEVICE_READY);
    EXPECT_TRUE(device.work.stop_called);
    device.end();
    EXPECT_EQ(device.reply().code(), REPLY_FAILED);
    EXPECT_EQ(
        device.text(),
        "the clock of device robot is 30 s " + std::string{ahead > seconds{0} ? "behind" : "ahead of"} +
            " the clock of device line (±50 us), more than the allowed 100 ms; synchronise the clocks of "
            "the two machines, for example with chrony or ptp4l");
    EXPECT_EQ(device.status().state(), DEVICE_WAITING);
  }
}

TEST(AgentClocks, AcceptsADeploymentIfTheClocksDifferLittle) {
  FakeDevice device;
  device.line_ahead = milliseconds{99};
  prepare(device);
  device.hear_line(DEVICE_READY);
  EXPECT_EQ(device.reply().code(), REPLY_OK);
}

TEST(AgentClocks, AreComparedBeforeADeviceIsReady) {
  FakeDevice device;
  prepare(device);
  DeviceStatus line = device.of_line(DEVICE_READY);
  line.echoes().clear();
  device.agent.receive(line, FakeDevice::kLine, device.now);
  device.agent.step();
  device.pass(seconds{10});
  EXPECT_TRUE(device.published.replies.empty()) << "line may not have received a status of robot yet";
  device.pass(milliseconds{1});
  device.end();
  EXPECT_EQ(device.reply().code(), REPLY_FAILED);
  EXPECT_EQ(device.text(),
            "it has had no answer from device line; check the network between the two devices");
}

TEST(AgentClocks, RecordsOnceThatAClockDiffersTooMuchAndThatItAgreesAgain) {
  FakeDevice device;
  device.become_running();
  device.hear_line(DEVICE_RUNNING);
  EXPECT_THAT(kinds(device), testing::ElementsAre("deployed"));
  device.line_ahead = seconds{1};
  for (int i = 0; i < 50; ++i) {
    device.now += milliseconds{100};
    device.hear_line(DEVICE_RUNNING);
  }
  EXPECT_THAT(kinds(device), testing::ElementsAre("deployed", "clocks-differ"));
  EXPECT_THAT(device.published.faults.back().cause().to_string(),
              StartsWith("the clock of device robot is 1 s behind the clock of device line"));
  device.line_ahead = milliseconds{1};
  device.now += milliseconds{100};
  device.hear_line(DEVICE_RUNNING);
  EXPECT_THAT(kinds(device), testing::ElementsAre("deployed", "clocks-differ", "clocks-agree"));
}

TEST(AgentClocks, AreComparedAgainAsSoonAsTheOwnClockIsSet) {
  FakeDevice device;
  device.become_running();
  device.hear_line(DEVICE_RUNNING);
  device.set = seconds{-2};
  device.line_ahead = seconds{2};
  device.pass(milliseconds{10});
  EXPECT_THAT(kinds(device), testing::ElementsAre("deployed", "clocks-differ")) << "without a further status";
}

TEST(AgentClocks, AreShownInTheReportAndStatusRelativeToTheFirstDeviceOfTheCell) {
  FakeDevice robot;
  robot.become_running();
  robot.receive(robot.command(COMMAND_REPORT));
  EXPECT_EQ(robot.data()["clock"],
            (nlohmann::ordered_json{{"reference", "robot"}, {"offset_us", 0.0}, {"bound_us", 0.0}}));
  EXPECT_EQ(robot.status().clock_error_ns(), 0);

  FakeDevice line{{}, false, {}, "", "line"};
  DeviceStatus status = line.of_line(DEVICE_READY);
  wire::set(status.device(), "robot");
  wire::set(status.node(), "here");
  wire::set(status.echoes()[0].node(), "node of line");
  status.time_ns(line.wall() + 2'000'000);
  line.agent.receive(status, 5, line.now);
  line.prepare();
  line.receive(line.command(COMMAND_REPORT));
  EXPECT_EQ(line.data()["clock"],
            (nlohmann::ordered_json{{"reference", "robot"}, {"offset_us", -2050.0}, {"bound_us", 50.0}}));
  EXPECT_EQ(line.status().clock_offset_ns(), -2'050'000);
  EXPECT_EQ(line.status().clock_error_ns(), 50'000);
}

}  // namespace
}  // namespace takt::agent::agent_clocks_test
