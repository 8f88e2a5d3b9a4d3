// The monotonic clock and the wall clock of the machine.
#pragma once

#include <cstdint>
#include <ctime>

#include <takt/core/clock.hpp>
#include <takt/core/time.hpp>

namespace takt::os {

/// The time of CLOCK_MONOTONIC through the vDSO. Takes about 20 ns and no system call if the clock source is
/// the TSC. Any thread may call it.
inline Instant now() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return from_ns(static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec);
}

/// Nanoseconds since 1970 (UTC), of the wall clock, which may be set.
std::int64_t wall_ns() noexcept;
/// The monotonic instant at which the wall clock shows this time, provided that nobody sets the wall clock
/// meanwhile. Exact to about a microsecond, even on a busy machine.
Instant instant_of_wall(std::int64_t wall_ns) noexcept;

/// Sleeps until an absolute instant; signals do not shorten it. Returns at once if it has passed. One system
/// call.
void sleep_until(Instant instant) noexcept;

/// The clock of an executor outside simulations and tests.
class MonotonicClock final : public Clock {
 public:
  Instant now() noexcept override { return os::now(); }
};

}  // namespace takt::os
