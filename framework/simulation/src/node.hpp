// One node of a simulated cell: the real agent, and the device on which it runs the cell. This class replaces
// the process takt-node of a real device, and the readers and writers of its status.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <takt/agent/agent.hpp>
#include "device.hpp"

namespace takt::simulation {

class Disk;

class Node final : private agent::Publisher {
 public:
  /// `address` is the index of the node in World::nodes. Nodes of one device have different addresses.
  Node(const World& world, std::uint32_t device, std::uint32_t address);
  ~Node() override;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  /// Calls `call` now. If the node is paused, calls it after the pause; if the node is down, does not call
  /// it.
  void deliver(const std::function<void()>& call);
  void receive(const wire::WholeCommand& command);
  /// Takes the status of another node.
  void hear(const DeviceStatus& status, std::uint32_t from, wire::WriterId writer);
  /// Stops the device and then the node, as SIGTERM does. A node that is down stays down.
  void end();
  [[nodiscard]] bool ended() const { return agent_ == nullptr || agent_->ended(); }
  /// Makes the agent react now, before its next regular step.
  void poke();

  /// The device loses its power. Its node starts again after this time, as with --resume.
  void go_down(Nanoseconds lasts);
  /// The node gets no CPU for this time. The modules of the device run on.
  void pause(Nanoseconds lasts);
  [[nodiscard]] bool is_down() const noexcept { return agent_ == nullptr; }

  /// Returns the device on which the cell runs or ran last; null until the agent begins to start its modules.
  [[nodiscard]] Device* device() const noexcept { return devices_.empty() ? nullptr : devices_.back().get(); }
  /// Returns all devices that the node has had, in order.
  [[nodiscard]] const std::vector<std::unique_ptr<Device>>& devices() const noexcept { return devices_; }

  [[nodiscard]] std::int64_t wall_of(Instant at) const noexcept { return to_ns(at) + wall_offset_.count(); }
  /// Sets the wall clock of the device.
  void set_clock(Nanoseconds by) noexcept { wall_offset_ += by; }

 private:
  /// What this node has heard from another node.
  struct Heard {
    std::string node;
    Instant at{};
    bool alive = false;
    bool answered = true;
    std::int64_t monotonic_ns = 0;  // of the newest status
  };

  void reply(const wire::WholeReply& reply) override;
  void publish(const LifecycleStatus& status) override;
  void publish(const DeviceStatus& status) override;
  void publish(const supervision::Measures&) override {}
  void publish(const FaultEvent&) override {}
  void withdraw(const std::vector<LifecycleStatus>& modules, const supervision::Measures&) override;

  void start(bool resume);
  [[nodiscard]] std::unique_ptr<agent::Agent> make_agent();
  void step();
  void step_regularly();
  void beat();
  void beat_regularly();
  /// Sends a message to each other node.
  void tell_others(bool reliable, const std::function<void(Node&)>& call);
  void tell(std::uint32_t other, bool reliable, const std::function<void(Node&)>& call);
  [[nodiscard]] Instant now() const noexcept { return world_.kernel.now(); }
  [[nodiscard]] bool is_paused() const noexcept { return now() < paused_until_; }
  [[nodiscard]] const std::string& name() const { return world_.cell().devices[index_].name; }
  /// The id of this node, and of its writers. A node that starts again has others.
  [[nodiscard]] std::string id() const;
  [[nodiscard]] wire::WriterId writer() const { return (std::uint64_t{starts_} << 32) + address_ + 1; }

  const World& world_;
  const std::uint32_t index_;
  const std::uint32_t address_;
  Draws draws_;
  Nanoseconds wall_offset_{};  // wall clock minus monotonic clock
  std::uint32_t starts_ = 0;
  Instant paused_until_{};
  std::map<wire::WriterId, Heard> heard_;
  std::map<std::string, LifecycleStatus> modules_;  // as published last, by path
  DeviceStatus status_;                             // as published last
  std::uint64_t sequence_ = 0;
  bool poked_ = false;
  bool ending_ = false;
  std::shared_ptr<Disk> disk_;
  // The devices outlive the agents that have supervised them, because events of the kernel refer to them.
  std::vector<std::unique_ptr<Device>> devices_;
  std::unique_ptr<agent::Agent> agent_;  // null while the node is down
};

}  // namespace takt::simulation
