// The health of a device's counters and ports: overruns, missed rows, stale inputs, lost connections. Each
// change for the worse, and each end of a disturbance, goes into the fault record.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/supervision/parts.hpp>
#include <takt/supervision/platform.hpp>
#include "fault_notes.hpp"

namespace takt::supervision {

struct Member;

class Health {
 public:
  /// All arguments must outlive this object. `flows` may still be null; it stays null if the device exchanges
  /// no samples with other devices.
  Health(Parts& parts, const std::vector<std::unique_ptr<Member>>& members,
         const std::unique_ptr<Flows>& flows, const FaultNotes& notes)
      : parts_(parts), members_(members), flows_(flows), notes_(notes) {}

  [[nodiscard]] PortHealth of(const Member& member, const model::Port& port, Instant now) const;
  void watch_counts();
  /// Checks every port, but not more often than once per kPortsEvery.
  void watch_ports(Instant now);
  /// Freezes the number of matched connections. Other devices may end from now on, and the final report must
  /// not count their connections as lost.
  void stop(Instant now);
  /// Checks all counters and ports for the last time.
  void finish(Instant now);

 private:
  void watch_port(const Member& member, const model::Port& port, Instant now);

  /// The part of a port's health that the fault record already contains.
  struct NotedPort {
    std::uint32_t matched = 0;
    bool lost = false;  ///< a connection that was matched is not matched now
    bool stale = false;
    std::uint64_t late = 0;
    std::uint64_t refused = 0;
  };
  using PortKey = std::pair<std::uint32_t, std::string>;  ///< module and port

  Parts& parts_;
  const std::vector<std::unique_ptr<Member>>& members_;
  const std::unique_ptr<Flows>& flows_;
  const FaultNotes& notes_;
  std::vector<std::uint64_t> noted_missed_;  ///< for each executor
  std::map<std::uint32_t, std::uint64_t> noted_overruns_;
  std::map<PortKey, NotedPort> noted_ports_;
  std::map<PortKey, std::uint32_t> matched_at_stop_;
  Instant ports_watched_at_{};
};

}  // namespace takt::supervision
