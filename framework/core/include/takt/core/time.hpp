// The types for instants and durations, and durations as text. Nothing here reads a clock: callers pass the
// time in.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace takt {

/// A duration in ns.
using Nanoseconds = std::chrono::nanoseconds;

/// A point on the machine's monotonic clock (CLOCK_MONOTONIC). Setting the wall clock does not change it.
using Instant = std::chrono::time_point<std::chrono::steady_clock, Nanoseconds>;

/// The nanoseconds since the monotonic clock's epoch, for places where time must be a number.
constexpr std::int64_t to_ns(Instant instant) { return instant.time_since_epoch().count(); }
/// The instant `ns` nanoseconds after the monotonic clock's epoch.
constexpr Instant from_ns(std::int64_t ns) { return Instant{Nanoseconds{ns}}; }

/// "100 us", "1.5 ms", "2 s": the largest unit in which the value is exact to three decimals. Allocates.
std::string to_text(Nanoseconds duration);

}  // namespace takt
