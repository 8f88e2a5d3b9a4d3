// Tests in which order client::deploy() sends its commands to the nodes. Fake nodes answer the commands over
// DDS.
#include <gmock/gmock.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <long_enough.hpp>
#include <takt/client/deploy.hpp>
#include <takt/dds/commands.hpp>
#include <takt/dds/topics.hpp>
#include <takt/wire/words.hpp>

#include "domain.hpp"

namespace takt::dds_test::deploy_test {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;
using testing::UnorderedElementsAre;

/// The commands that all fake nodes received, in order of arrival: "robot prepare".
class Received {
 public:
  void add(const std::string& command) {
    const std::lock_guard lock{mutex_};
    commands_.push_back(command);
  }
  [[nodiscard]] std::vector<std::string> all() const {
    const std::lock_guard lock{mutex_};
    return commands_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> commands_;
};

// The client and the fake nodes share a participant, because a process has only one.
std::shared_ptr<dds::Participant> participate() {
  auto made = dds::Participant::create(on_loopback("test"));
  EXPECT_TRUE(made.ok()) << to_text(made.problems());
  return made.ok() ? *made : nullptr;
}

/// A node that waits for a deployment, as its status says, and accepts every command except those of the kind
/// `refused`.
class FakeNode {
 public:
  FakeNode(const std::shared_ptr<dds::Participant>& participant, const std::string& device,
           Received& received, std::optional<CommandKind> refused = {})
      : status_(std::move(*dds::Writer<DeviceStatus>::create(participant))),
        server_(std::move(*dds::CommandServer::create(
            participant, device, "node of " + device,
            [this, device, &received, refused](const wire::WholeCommand& command) {
              if (command.head.kind() != COMMAND_REPORT)
                received.add(device + " " + to_text(command.head.kind()));
              wire::WholeReply reply{.head = {}, .data = "{}"};
              reply.head.id(command.head.id());
              wire::set(reply.head.device(), device);
              const bool fails = command.head.kind() == refused;
              reply.head.code(fails ? REPLY_FAILED : REPLY_OK);
              if (fails) wire::set(reply.head.text(), "the test rejects it");
              server_.reply(reply);
            }))),
        publisher_([this, device] { publish(device); }) {}
  ~FakeNode() {
    ended_ = true;
    publisher_.join();
  }
  FakeNode(const FakeNode&) = delete;
  FakeNode& operator=(const FakeNode&) = delete;

 private:
  void publish(const std::string& device) {
    DeviceStatus status;
    wire::set(status.path(), wire::path_of(wire::kNoCell, device));
    wire::set(status.cell(), wire::kNoCell);
    wire::set(status.device(), device);
    wire::set(status.node(), "node of " + device);
    status.state(DEVICE_WAITING);
    for (std::uint64_t sequence = 1; !ended_; ++sequence) {
      status.sequence_number(sequence);
      status_.write(status);
      std::this_thread::sleep_for(50ms);
    }
  }

  dds::Writer<DeviceStatus> status_;
  dds::CommandServer server_;
  std::atomic<bool> ended_{false};
  std::thread publisher_;
};

/// Deploys a cell in which robot has a connection to line, and desk has none to another device. Returns the
/// problems of the deployment.
std::string problems_of_deployment(const std::shared_ptr<dds::Participant>& participant) {
  model::Cell cell;
  cell.name = "cell";
  for (const char* device : {"robot", "line", "desk"}) {
    model::Module module;
    module.name = "m";
    cell.devices.push_back({.name = device, .executors = {{}}, .modules = {module}});
  }
  model::Connection& connection = cell.connections.emplace_back();
  connection.from = {"robot", "m", "out"};
  connection.to = {"line", "m", "in"};
  model::Connection& within = cell.connections.emplace_back();
  within.from = {"desk", "m", "out"};
  within.to = {"desk", "m", "in"};
  const auto observer = client::Observer::create(participant);
  if (!observer) return to_text(observer.problems());
  const auto sender = client::Operator::create(participant, **observer, domain(), "");
  if (!sender) return to_text(sender.problems());
  client::DeployOptions options;
  options.discovery = long_enough();
  const auto deployed = client::deploy(**sender, cell, "<cell/>", options);
  return deployed ? "" : to_text(deployed.problems());
}

TEST(Deploy, SendsT0OnlyWhenAllDevicesHaveStartedTheirModules) {
  const auto participant = participate();
  Received received;
  const FakeNode robot{participant, "robot", received, COMMAND_RUN};
  const FakeNode line{participant, "line", received, COMMAND_RUN};
  const FakeNode desk{participant, "desk", received, COMMAND_RUN};
  EXPECT_THAT(problems_of_deployment(participant), HasSubstr("the test rejects it"));
  const auto all = received.all();
  ASSERT_GE(all.size(), 9U);
  EXPECT_THAT(std::vector(all.begin(), all.begin() + 3),
              UnorderedElementsAre("robot prepare", "line prepare", "desk prepare"));
  EXPECT_THAT(std::vector(all.begin() + 3, all.begin() + 6),
              UnorderedElementsAre("robot change", "line change", "desk change"));
  EXPECT_THAT(std::vector(all.begin() + 6, all.begin() + 9),
              UnorderedElementsAre("robot run", "line run", "desk run"));
}

TEST(Deploy, SendsNoT0IfADeviceCannotStartItsModules) {
  const auto participant = participate();
  Received received;
  const FakeNode robot{participant, "robot", received};
  const FakeNode line{participant, "line", received, COMMAND_CHANGE};
  const FakeNode desk{participant, "desk", received};
  EXPECT_THAT(problems_of_deployment(participant), HasSubstr("device line: error: the test rejects it"));
  const auto all = received.all();
  for (const char* device : {"robot", "line", "desk"}) {
    EXPECT_THAT(all, Contains(device + std::string{" undeploy"}));
    EXPECT_THAT(all, Not(Contains(device + std::string{" run"})));
  }
}

}  // namespace
}  // namespace takt::dds_test::deploy_test
