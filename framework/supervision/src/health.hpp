// The health of a device's counters and ports: overruns, missed rows, stale inputs, lost connections, full
// queues. Each change for the worse, and each end of a disturbance, goes into the fault record.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/supervision/parts.hpp>
#include <takt/supervision/platform.hpp>
#include <takt/wire/judgement.hpp>
#include "fault_notes.hpp"

namespace takt::supervision {

struct Member;

class Health {
 public:
  /// All references must outlive this object. `flows` may be null at first, and stays null if the device
  /// exchanges no samples with other devices.
  Health(Parts& parts, const std::vector<std::unique_ptr<Member>>& members,
         const std::unique_ptr<Flows>& flows, const FaultNotes& notes, Wiring::IsLost is_lost)
      : parts_(parts), members_(members), flows_(flows), notes_(notes), is_lost_(std::move(is_lost)) {}

  [[nodiscard]] PortHealth of(const Member& member, const model::Port& port, Instant now) const;
  /// Judges the connections of a port. Empty if the port has none, or if the device does not run.
  [[nodiscard]] std::optional<wire::Judgement> judge(const model::Port& port, const PortHealth& health) const;
  void check_counts();
  /// Checks every port, but not more often than once per kPortsEvery.
  void check_ports(Instant now);
  /// Freezes the number of matched connections. From now on, other devices may end, and the final report must
  /// not count their connections as lost.
  void stop(Instant now);
  /// Checks all counters and ports for the last time.
  void finish(Instant now);

 private:
  void check_port(const Member& member, const model::Port& port, Instant now);
  /// Records each queue that has begun to drop samples. A queue is recorded again only if it has dropped no
  /// sample for wire::kRecently.
  void check_queues(Instant now);

  /// The part of a port's health that the fault record already contains.
  struct NotedPort {
    std::uint32_t matched = 0;
    bool lost = false;  ///< true if a connection that was matched is not matched now
    bool stale = false;
    std::uint64_t late = 0;
    std::uint64_t refused = 0;
    wire::RisingCount losses{0};
  };
  struct NotedQueue {
    std::uint64_t dropped = 0;
    wire::RisingCount drops{0};
  };
  using PortKey = std::pair<std::uint32_t, std::string>;  ///< index of the module, and name of the port

  Parts& parts_;
  const std::vector<std::unique_ptr<Member>>& members_;
  const std::unique_ptr<Flows>& flows_;
  const FaultNotes& notes_;
  const Wiring::IsLost is_lost_;
  std::vector<std::uint64_t> noted_missed_;  ///< the recorded number of missed rows, for each executor
  std::map<std::uint32_t, std::uint64_t> noted_overruns_;
  std::map<PortKey, NotedPort> noted_ports_;
  std::vector<NotedQueue> noted_queues_;  ///< one for each link
  std::map<PortKey, std::uint32_t> matched_at_stop_;
  Instant ports_watched_at_{};
  bool stopped_ = false;
};

}  // namespace takt::supervision
