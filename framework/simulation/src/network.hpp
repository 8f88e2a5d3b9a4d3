// The network between the devices of a simulated cell.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "device.hpp"

namespace takt::simulation {

/// Carries samples, and the messages between nodes, in order; each takes a few tenths of a millisecond.
/// lose() and delay() inject faults. While a link is cut, best-effort samples and messages are lost, and
/// reliable ones arrive after the cut.
class Network {
 public:
  /// The address of the operator. The address of a node is its index in World::nodes.
  static constexpr std::uint32_t kOperator = ~0U;
  explicit Network(const World& world);

  /// Sets the destination of a connection's samples.
  void connect(Device& device, SimulatedLink& link);
  /// No sample arrives at the device any more.
  void disconnect(const Device& device);
  void send(std::uint32_t version, const SimulatedLink& from, const std::byte* sample, std::int64_t wall_ns);
  /// Sends a message from one address to another. Calls `arrive` when it has arrived.
  void tell(std::uint32_t from, std::uint32_t to, bool reliable, std::function<void()> arrive);

  void cut(std::uint32_t a, std::uint32_t b, Nanoseconds time);
  /// `connection` is the number of a connection.
  void lose(std::uint32_t connection, std::uint64_t count) { ways_[connection].to_lose += count; }
  void delay(std::uint32_t connection, Nanoseconds by) { ways_[connection].to_delay += by; }
  /// True if the link between the two devices of a connection is cut now.
  [[nodiscard]] bool is_cut(std::uint32_t connection) const;
  [[nodiscard]] std::uint64_t lost(std::uint32_t connection) const { return ways_[connection].lost; }

 private:
  struct Way {
    Device* to = nullptr;
    SimulatedLink* link = nullptr;
    std::pair<std::uint32_t, std::uint32_t> between{};  // the devices, the lower index first
    Instant last{};                                     // arrival time of the last sample
    std::uint64_t to_lose = 0;
    std::uint64_t lost = 0;
    Nanoseconds to_delay{};
  };

  [[nodiscard]] Nanoseconds latency(Draws& draws);
  /// Returns when something that would arrive at `arrival` does arrive; nothing if it is lost.
  [[nodiscard]] std::optional<Instant> past_cuts(std::pair<std::uint32_t, std::uint32_t> between,
                                                 Instant arrival, bool reliable, Draws& draws) const;

  const World& world_;
  Draws draws_;
  Draws message_draws_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Instant> last_told_;  // by sender and receiver
  std::vector<Way> ways_;                                                 // by the number of the connection
  std::map<std::pair<std::uint32_t, std::uint32_t>, Instant> cut_until_;
};

}  // namespace takt::simulation
