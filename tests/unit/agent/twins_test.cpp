// Two nodes with the name `robot` on virtual time, and a device `line` of the same cell. Cables are cut and
// nodes are killed. The agents are real; the network and the work of the devices are models.
#include <takt/agent/agent.hpp>

#include <gmock/gmock.h>

#include <filesystem>
#include <memory>
#include <optional>

#include <full_form.hpp>
#include <temporary_folder.hpp>

#include "fake_device.hpp"

namespace takt::agent::twins_test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;
using testing::HasSubstr;
using Phase = Supervised::Phase;

constexpr milliseconds kTick{20};
constexpr milliseconds kLease{300};
constexpr milliseconds kHeartbeat{100};

class Twins : public testing::Test {
 protected:
  /// A node that starts with --resume. Its state folder contains the running deployment.
  struct Node {
    Node(const std::string& folder, const std::string& id)
        : file{std::make_shared<node::DeploymentFile>(folder, "robot", 7)}, device{file, false,   nullptr,
                                                                                   "",   "robot", id} {
      device.work.inspected = Inspected{.paths = {"/servo.so", "/arm.so"}};
      EXPECT_TRUE(file->keep({.current = KeptDeployment{.id = "d1",
                                                        .transaction = "d1",
                                                        .file = "cell.xml",
                                                        .text = FakeDevice::kCell,
                                                        .t0_ns = device.wall(),
                                                        .boot = "since today",
                                                        .t0_monotonic_ns = to_ns(device.now),
                                                        .devices = {"robot", "line"}}})
                      .ok());
    }
    std::shared_ptr<node::DeploymentFile> file;
    FakeDevice device;
    bool connected = true;
    Phase phase = Phase::preparing;
    Nanoseconds phase_since{0};
    std::uint64_t sequence = 0;
    DeviceStatus sent;  ///< the last status that the network has taken from this node
    Nanoseconds sent_at{0};
    std::optional<Nanoseconds> heard_at[2];  ///< when this node has heard the other node, and line
  };

  void TearDown() override { std::filesystem::remove_all(folder_); }

  void start(std::size_t i) {
    nodes_[i] = std::make_unique<Node>(folder_ + "/" + std::to_string(i), i == 0 ? first_id_ : second_id_);
    nodes_[i]->device.now = from_ns(5'000'000'000) + time_;
    nodes_[i]->device.agent.resume();
  }
  void kill(std::size_t i) { nodes_[i].reset(); }
  Node& node(std::size_t i) { return *nodes_[i]; }

  void run(Nanoseconds duration) {
    for (const Nanoseconds end = time_ + duration; time_ < end; time_ += kTick) {
      for (std::size_t i = 0; i < 2; ++i) {
        if (nodes_[i]) step(*nodes_[i]);
      }
      for (std::size_t i = 0; i < 2; ++i) {
        if (nodes_[i] && nodes_[i]->device.agent.ended()) {
          ended_[i] = nodes_[i]->device.agent.has_given_way();
          if (Node* const other = nodes_[1 - i].get())
            other->device.agent.others().remove(nodes_[i]->sent, writer(*nodes_[i]));
          ends_.push_back(std::move(nodes_[i]));
        }
      }
    }
  }
  [[nodiscard]] bool executes(std::size_t i) const {
    return nodes_[i] && nodes_[i]->device.work.supervised > 0 &&
           nodes_[i]->device.work.phase == Phase::running;
  }
  /// True if this node has not even loaded a module.
  [[nodiscard]] bool does_nothing(std::size_t i) const {
    return nodes_[i] && nodes_[i]->device.work.inspections.empty() && nodes_[i]->device.work.supervised == 0;
  }
  /// Runs one node without the other until it has executed for a while.
  void run_alone(std::size_t i) {
    start(i);
    run(seconds{10});
    ASSERT_TRUE(executes(i));
  }

  std::string first_id_ = "here";
  std::string second_id_ = "there";
  bool line_is_on_ = true;
  Nanoseconds time_{0};
  std::optional<bool> ended_[2];  ///< by node: whether it has ended because it gave way
  std::vector<std::unique_ptr<Node>> ends_;

 private:
  static constexpr wire::WriterId kLine = 99;
  [[nodiscard]] wire::WriterId writer(const Node& one) const {
    return one.device.status().node() == first_id_ ? 1 : 2;
  }

  void step(Node& one) {
    FakeDevice& device = one.device;
    device.now = from_ns(5'000'000'000) + time_;
    hear_line(one);
    for (const auto& other : nodes_) {
      if (other && other.get() != &one) hear(one, *other);
    }
    if (one.heard_at[0] && time_ - *one.heard_at[0] > kLease) {
      one.heard_at[0].reset();
      device.agent.others().lost(writer(one) == 1 ? 2 : 1);
    }
    if (device.work.supervised == 0 || device.work.phase != one.phase) {
      one.phase = device.work.phase;
      one.phase_since = time_;
    }
    const Nanoseconds lasted = time_ - one.phase_since;
    if (device.work.supervised > 0 && lasted >= milliseconds{100}) {
      if (one.phase == Phase::preparing) device.work.phase = Phase::ready;
      if (one.phase == Phase::stopping) device.work.phase = Phase::ended;
    }
    device.agent.step();
    const DeviceStatus& status = device.status();
    if (one.sequence != 0 && time_ - one.sent_at < kHeartbeat && status.state() == one.sent.state()) return;
    one.sent = status;
    one.sent.sequence_number(++one.sequence);
    one.sent_at = time_;
  }
  void hear(Node& one, const Node& other) {
    if (!one.connected || !other.connected || other.sequence == 0) return;
    one.device.agent.others().receive(other.sent, writer(other));
    one.heard_at[0] = time_;
  }
  void hear_line(Node& one) {
    if (one.connected && line_is_on_) {
      one.device.agent.others().receive(one.device.of_line(DEVICE_RUNNING), kLine);
      one.heard_at[1] = time_;
    } else if (one.heard_at[1] && time_ - *one.heard_at[1] > kLease) {
      one.heard_at[1].reset();
      one.device.agent.others().lost(kLine);
    }
  }

  std::string folder_ = temporary_folder("twins");
  std::unique_ptr<Node> nodes_[2];
};

TEST_F(Twins, TheSecondNodeDoesNothingWhileTheFirstExecutes) {
  run_alone(0);
  start(1);
  run(seconds{30});
  EXPECT_TRUE(executes(0));
  EXPECT_TRUE(does_nothing(1));
  const DeviceStatus& status = node(1).device.status();
  EXPECT_EQ(status.state(), DEVICE_WAITING);
  EXPECT_EQ(status.health(), HEALTH_DEGRADED);
  EXPECT_THAT(status.text().to_string(), HasSubstr("which has executed cell cell without interruption for "));
  for (const std::size_t i : {0U, 1U}) {
    node(i).device.receive(node(i).device.command(COMMAND_STOP));
    EXPECT_EQ(node(i).device.reply().code(), REPLY_REFUSED);
    EXPECT_THAT(node(i).device.text(), HasSubstr("2 nodes on domain 7 have this name: "));
  }
  EXPECT_TRUE(node(0).device.work.commands.empty());
}

TEST_F(Twins, TheSecondNodeResumesTenSecondsAfterTheFirstIsGone) {
  run_alone(0);
  start(1);
  run(seconds{5});
  kill(0);
  run(seconds{10});
  EXPECT_TRUE(does_nothing(1)) << "the network of the first node may be back soon";
  run(seconds{2});
  EXPECT_TRUE(executes(1));
  node(1).device.receive(node(1).device.command(COMMAND_START));
  EXPECT_FALSE(node(1).device.work.commands.empty()) << "it accepts commands";
}

TEST_F(Twins, TheFirstNodeKeepsTheDeviceDuringAShortLossOfTheNetwork) {
  run_alone(0);
  start(1);
  run(seconds{5});
  node(0).connected = false;
  run(seconds{8});
  node(0).connected = true;
  run(seconds{20});
  EXPECT_TRUE(executes(0));
  EXPECT_TRUE(does_nothing(1));
}

TEST_F(Twins, ANodeThatWasCutOffEndsIfAnotherNodeHasTakenItsPlace) {
  run_alone(0);
  node(0).connected = false;
  run(seconds{1});
  run_alone(1);
  const Node& cut_off = node(0);
  const std::size_t steps = cut_off.device.published.steps.size();
  const std::size_t steps_of_second = node(1).device.published.steps.size();
  node(0).connected = true;
  run(seconds{2});
  EXPECT_EQ(ended_[0], true);
  EXPECT_TRUE(executes(1));
  EXPECT_TRUE(cut_off.device.work.stop_called);
  ASSERT_FALSE(cut_off.device.published.faults.empty());
  bool reported = false;
  for (const FaultEvent& event : cut_off.device.published.faults)
    reported |= event.kind() == FAULT_DEVICE_FAILED &&
                event.cause().to_string().find("another node named robot") != std::string::npos;
  EXPECT_TRUE(reported);
  EXPECT_EQ(cut_off.device.published.steps.size(), steps) << "the states of the other node's modules stay";
  EXPECT_TRUE(cut_off.device.published.withdrawn.empty());
  EXPECT_EQ(node(1).device.published.steps.size(), steps_of_second + 2)
      << "observers get the states of the remaining node again";
  EXPECT_TRUE(cut_off.file->kept()->current) << "a restarted node waits for the other node";
}

TEST_F(Twins, ANodeThatBeganWhileItWasCutOffEnds) {
  run_alone(0);
  start(1);
  node(1).connected = false;
  run(seconds{30});
  ASSERT_TRUE(executes(1)) << "it cannot know of the other node";
  node(1).connected = true;
  run(seconds{2});
  EXPECT_EQ(ended_[1], true);
  EXPECT_TRUE(executes(0));
}

TEST_F(Twins, TheRemainsOfAKilledNodeDelayItsSuccessorOnlyForTheLease) {
  run_alone(0);
  const DeviceStatus last = node(0).sent;
  kill(0);
  run(milliseconds{100});
  start(1);
  node(1).device.agent.others().receive(last, 1);
  node(1).heard_at[0] = time_;
  run(kLease);
  EXPECT_TRUE(does_nothing(1)) << "it could be a live node";
  run(milliseconds{100});
  EXPECT_FALSE(does_nothing(1));
  run(milliseconds{200});
  EXPECT_TRUE(executes(1));
}

TEST_F(Twins, OneOfTwoNodesExecutesIfBothStartAtTheSameTime) {
  start(0);
  start(1);
  run(seconds{20});
  EXPECT_NE(executes(0), executes(1));
}

// The nodes compare numbers that are up to a heartbeat old, so they may not agree who has executed longer.
TEST_F(Twins, ExactlyOneNodeRemainsAfterAnyTimesOfStartAndReconnection) {
  const milliseconds step{kSanitized ? 500 : 100};
  for (const bool first_is_smaller : {true, false}) {
    first_id_ = first_is_smaller ? "a" : "z";
    second_id_ = "m";
    for (const bool line_is_on : {true, false}) {
      line_is_on_ = line_is_on;
      for (milliseconds between{0}; between < seconds{7}; between += step) {
        SCOPED_TRACE(std::to_string(between.count()) + " ms between the starts");
        start(0);
        node(0).connected = false;
        run(between);
        start(1);
        node(1).connected = false;
        run(milliseconds{1300});
        node(static_cast<std::size_t>(between.count()) / 100 % 2).connected = true;
        run(between / 2);
        node(0).connected = true;
        node(1).connected = true;
        run(seconds{5});
        EXPECT_NE(executes(0), executes(1));
        kill(0);
        kill(1);
      }
    }
  }
}

}  // namespace
}  // namespace takt::agent::twins_test
