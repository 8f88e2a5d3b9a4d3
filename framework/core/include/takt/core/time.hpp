// Instants and spans of time. Nothing here reads a clock: time is a value that is handed in.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace takt {

using Nanoseconds = std::chrono::nanoseconds;

/// A point on the machine's monotonic clock (CLOCK_MONOTONIC), which no clock step moves.
using Instant = std::chrono::time_point<std::chrono::steady_clock, Nanoseconds>;

/// Nanoseconds since the monotonic clock's epoch, for places where time must be a number.
constexpr std::int64_t to_ns(Instant instant) { return instant.time_since_epoch().count(); }
constexpr Instant from_ns(std::int64_t ns) { return Instant{Nanoseconds{ns}}; }

/// "100 us", "1.5 ms", "2 s": the largest unit in which the value is exact to three decimals. Allocates.
std::string to_text(Nanoseconds duration);

}  // namespace takt
