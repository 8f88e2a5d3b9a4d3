// The network between the devices of a simulated cell.
#pragma once

#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "device.hpp"

namespace takt::simulation {

/// Carries samples in order; each sample takes a few tenths of a millisecond. lose() and delay() inject
/// faults. While a link is cut, best-effort samples are lost, and reliable samples arrive after the cut.
class Network {
 public:
  explicit Network(const World& world);

  /// Sets the destination of a connection's samples.
  void connect(std::uint32_t connection, Device& device, SimulatedLink& link);
  void send(std::uint32_t connection, const std::byte* sample, std::int64_t wall_ns);

  void cut(std::uint32_t a, std::uint32_t b, Nanoseconds time);
  void lose(std::uint32_t connection, std::uint64_t count);
  void delay(std::uint32_t connection, Nanoseconds by);
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

  const World& world_;
  Draws draws_;
  std::vector<Way> ways_;
  std::map<std::pair<std::uint32_t, std::uint32_t>, Instant> cut_until_;
};

}  // namespace takt::simulation
