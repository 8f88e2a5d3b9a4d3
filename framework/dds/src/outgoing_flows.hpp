// Moves the samples of outgoing flows from links to DDS, on one thread.
//
// DDS may take long to write a sample, for example while the network takes no packets. The node's main thread
// asks for the health of each flow in every step, and must not wait for such a write. So only remove() waits
// for a lock that is held during a write.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include <takt/channel/link.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/gateway.hpp>
#include <takt/os/real_time.hpp>
#include <takt/wire/flow_health.hpp>
#include "raw.hpp"

namespace takt::dds {

/// The time on the wall clock and on the monotonic clock, read at the same moment.
struct Now {
  Now();
  std::int64_t wall_ns;
  std::int64_t monotonic_ns;

  [[nodiscard]] std::int64_t wall_of(std::int64_t monotonic) const {
    return wall_ns - (monotonic_ns - monotonic);
  }
  /// Returns the earliest monotonic time at which the wall clock of a sample's writer may have shown `wall`.
  /// `writer_clock` is an upper bound of the writer's wall clock minus this machine's monotonic clock. If it
  /// is 0, the bound is not known, and the wall clock of this machine is used instead. Returns nothing if the
  /// result is in the future or too old, because the clocks then differ in an unknown way.
  [[nodiscard]] std::optional<std::int64_t> monotonic_of(std::int64_t wall, std::int64_t writer_clock) const;
};

/// Wakes the threads that sleep on these bits of the wake word.
void ring(channel::WakeWord& wake_word, std::uint32_t bits) noexcept;

class OutgoingFlows {
 public:
  using FlowId = Gateway::FlowId;

  OutgoingFlows(channel::WakeWord& wake_word, std::uint32_t place) noexcept;
  ~OutgoingFlows();
  Result<void> start();

  void add(FlowId id, std::unique_ptr<SampleWriter> writer, channel::Link from);
  /// See Gateway::thin_out().
  void thin_out(FlowId id, Nanoseconds every);
  /// Waits until no sample of the flow is being written. When remove() has returned, the flow's link is not
  /// accessed any more.
  void remove(FlowId id);
  /// Returns the counters of a flow; none if there is no such flow.
  [[nodiscard]] std::optional<wire::FlowHealth> health(FlowId id) const;

 private:
  class Outgoing;
  using Flows = std::vector<std::shared_ptr<Outgoing>>;
  void pump();
  void refresh(Flows& flows);

  channel::WakeWord& wake_word_;
  const std::uint32_t sleeps_;  // this gateway's bit of WakeWord::gateway_sleeps
  mutable std::mutex mutex_;    // never held during a write
  std::map<FlowId, std::shared_ptr<Outgoing>> flows_;
  bool changed_ = false;  // true if a flow was added or removed since the last refresh()
  std::atomic<bool> ending_{false};
  os::Thread pump_;
};

}  // namespace takt::dds
