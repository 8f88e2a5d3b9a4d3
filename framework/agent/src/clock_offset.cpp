#include <takt/agent/clock_offset.hpp>

#include <algorithm>

namespace takt::agent {

namespace {

/// The latest wall clock that is believed, in the year 2116. Sums of times up to this one do not overflow.
constexpr std::int64_t kLatest = std::int64_t{1} << 62U;
/// An answer that took longer than this is not used.
constexpr Nanoseconds kLongest = std::chrono::seconds{60};
/// If both bounds move in one direction by more than this, the clock was probably set.
constexpr Nanoseconds kStep = std::chrono::milliseconds{1};

bool is_valid(std::int64_t wall_ns) { return wall_ns >= 0 && wall_ns < kLatest; }

}  // namespace

void ClockOffset::heard(std::int64_t wall_ns, Instant arrived) {
  const auto known = at(arrived);
  if (is_valid(wall_ns) && known && wall_ns - to_ns(arrived) > known->high_ns) bounds_.reset();
}

void ClockOffset::answered(std::int64_t wall_ns, Instant sent, Nanoseconds held, Instant arrived) {
  const std::int64_t earliest = to_ns(arrived) - kLongest.count();
  if (!is_valid(wall_ns) || to_ns(sent) < earliest || sent > arrived || held < -kLongest || held > kLongest)
    return;
  // The other node sent its status after `sent + held` and before `arrived`.
  const ClockBounds measured{.low_ns = wall_ns - to_ns(arrived), .high_ns = wall_ns - to_ns(sent + held)};
  if (measured.low_ns > measured.high_ns) return;
  // If the clock was set by less than the round trip takes, the earlier bounds do not contradict the new
  // ones, but no longer contain the true value. The delays of messages alone can hardly move both bounds.
  if (bounds_) {
    const std::int64_t slack = drift_until(arrived) + kStep.count();
    const std::int64_t low = measured.low_ns - bounds_->low_ns;
    const std::int64_t high = measured.high_ns - bounds_->high_ns;
    if (std::min(low, high) > slack || std::max(low, high) < -slack) bounds_.reset();
  }
  const ClockBounds known = at(arrived).value_or(measured);
  const ClockBounds both{.low_ns = std::max(known.low_ns, measured.low_ns),
                         .high_ns = std::min(known.high_ns, measured.high_ns)};
  bounds_ = both.low_ns <= both.high_ns ? both : measured;
  measured_ = arrived;
}

std::int64_t ClockOffset::drift_until(Instant now) const {
  return std::max<std::int64_t>((now - measured_).count(), 0) / kDrift;
}

std::optional<ClockBounds> ClockOffset::at(Instant now) const {
  if (!bounds_) return std::nullopt;
  const std::int64_t drift = drift_until(now);
  return ClockBounds{.low_ns = bounds_->low_ns - drift, .high_ns = bounds_->high_ns + drift};
}

}  // namespace takt::agent
