// Types for times and durations, and durations as text. The functions read no clock.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace takt {

/// A duration in ns.
using Nanoseconds = std::chrono::nanoseconds;

/// A time on the machine's monotonic clock (CLOCK_MONOTONIC), which does not change when the wall clock is
/// set.
using Instant = std::chrono::time_point<std::chrono::steady_clock, Nanoseconds>;

/// Returns the nanoseconds from the epoch of the monotonic clock to `instant`.
constexpr std::int64_t to_ns(Instant instant) { return instant.time_since_epoch().count(); }
/// Returns the time `ns` nanoseconds after the epoch of the monotonic clock.
constexpr Instant from_ns(std::int64_t ns) { return Instant{Nanoseconds{ns}}; }

/// Returns the duration as text in the largest unit that shows it exactly with at most three decimals, for
/// example "100 us", "1.5 ms" or "2 s". Allocates memory.
std::string to_text(Nanoseconds duration);

}  // namespace takt
