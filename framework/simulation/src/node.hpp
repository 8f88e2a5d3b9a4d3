// One node of a simulated cell: the real agent, and the device on which it runs the cell. This class replaces
// the process takt-node of a real device, and the readers and writers of its status.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <takt/agent/agent.hpp>
#include "device.hpp"

namespace takt::simulation {

class Node final : private agent::Publisher {
 public:
  Node(const World& world, std::uint32_t index);
  ~Node() override;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  void receive(const wire::WholeCommand& command);
  /// Returns the replies that the agent has sent, and forgets them.
  [[nodiscard]] std::vector<wire::WholeReply> take_replies();
  /// Stops the device and then the node, as SIGTERM does.
  void end();
  [[nodiscard]] bool ended() const { return agent_->ended(); }
  /// Returns the device on which the cell runs; null until the agent begins to start its modules.
  [[nodiscard]] Device* device() const noexcept { return device_.get(); }
  /// Makes the agent react now, before its next regular step.
  void poke();

  [[nodiscard]] std::int64_t wall_of(Instant at) const noexcept { return to_ns(at) + wall_offset_.count(); }
  /// Sets the wall clock of the device.
  void set_clock(Nanoseconds by) noexcept { wall_offset_ += by; }

 private:
  /// What this node has heard from another node.
  struct Heard {
    Instant at{};
    bool alive = false;
    bool answered = true;
    std::int64_t monotonic_ns = 0;  // of the newest status
  };

  void reply(const wire::WholeReply& reply) override { replies_.push_back(reply); }
  void publish(const LifecycleStatus& status) override;
  void publish(const DeviceStatus& status) override;
  void publish(const supervision::Measures&) override {}
  void publish(const FaultEvent&) override {}
  void withdraw(const std::vector<LifecycleStatus>& modules, const supervision::Measures&) override;

  [[nodiscard]] std::unique_ptr<agent::Agent> make_agent();
  void step();
  void step_regularly();
  void beat();
  void beat_regularly();
  void hear(const DeviceStatus& status, std::uint32_t from);
  template <class Call>
  void tell_others(bool reliable, const Call& call);
  [[nodiscard]] Instant now() const noexcept { return world_.kernel.now(); }
  [[nodiscard]] const std::string& name() const { return world_.cell.devices[index_].name; }

  const World& world_;
  const std::uint32_t index_;
  Draws draws_;
  Nanoseconds wall_offset_{};  // wall clock minus monotonic clock
  std::vector<Heard> heard_;   // by the index of the other device
  DeviceStatus status_;        // as published last
  std::uint64_t sequence_ = 0;
  std::vector<wire::WholeReply> replies_;
  bool poked_ = false;
  std::unique_ptr<Device> device_;  // outlives the agent, which owns the supervision of the device
  std::unique_ptr<agent::Agent> agent_;
};

}  // namespace takt::simulation
