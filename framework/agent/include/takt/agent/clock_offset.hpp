// Bounds on the wall clock of another machine, from the statuses that two nodes exchange.
#pragma once

#include <cstdint>
#include <optional>

#include <takt/core/time.hpp>

namespace takt::agent {

/// The wall clock of another node's machine minus the monotonic clock of this machine is between these two
/// values. The difference does not change when somebody sets the wall clock of this machine.
struct ClockBounds {
  std::int64_t low_ns = 0;
  std::int64_t high_ns = 0;
};

/// Measures the wall clock of another node. The other node answers a status of this node with its own next
/// status, so four times are known: when this node sent, when the other node received and answered, and when
/// the answer arrived. The delays of the two messages are not known, but neither is negative. So the bounds
/// always contain the true value, and they are as far apart as the round trip is long. Bounds that were
/// measured earlier become wider with time, because clocks drift; new bounds narrow them. If the bounds
/// contradict each other, or if both move in the same direction, the clock was set, and only the newest
/// count. The class reads no clock.
class ClockOffset {
 public:
  /// Two clocks drift apart by at most one 2000th: the kernel adjusts a clock by at most 500 ppm.
  static constexpr std::int64_t kDrift = 2000;

  /// Notes that a status has arrived that the other node sent when its wall clock showed `wall_ns`.
  void heard(std::int64_t wall_ns, Instant arrived);
  /// Notes that this status also answers a status that this node sent at `sent`. The other node waited for
  /// the time `held` before it answered.
  void answered(std::int64_t wall_ns, Instant sent, Nanoseconds held, Instant arrived);

  /// Returns the bounds at `now`. Returns nothing before the first answer. If the other clock was set
  /// forward, also returns nothing until the next answer.
  [[nodiscard]] std::optional<ClockBounds> at(Instant now) const;

 private:
  /// Returns how far the two clocks may have drifted apart since the last answer.
  [[nodiscard]] std::int64_t drift_until(Instant now) const;

  std::optional<ClockBounds> bounds_;
  Instant measured_{};
};

}  // namespace takt::agent
