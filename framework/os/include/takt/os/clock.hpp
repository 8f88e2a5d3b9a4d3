// The monotonic clock and the wall clock of the machine.
#pragma once

#include <cstdint>
#include <ctime>

#include <takt/core/clock.hpp>
#include <takt/core/time.hpp>

namespace takt::os {

/// The time of CLOCK_MONOTONIC, read through the vDSO. If the clock source is the TSC, this takes about 20 ns
/// and no system call. Any thread may call it.
inline Instant now() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return from_ns(static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec);
}

/// The wall clock as nanoseconds since 1970 (UTC). The wall clock may be set.
std::int64_t wall_ns() noexcept;
/// The monotonic time at which the wall clock will show this time, provided that nobody sets the wall clock
/// meanwhile. Accurate to about a microsecond, even on a busy machine.
Instant instant_of_wall(std::int64_t wall_ns) noexcept;

/// Sleeps until an absolute time; signals do not end the sleep. Returns at once if the time has passed. One
/// system call.
void sleep_until(Instant instant) noexcept;

/// The real clock of an executor. Simulations and tests use other clocks.
class MonotonicClock final : public Clock {
 public:
  Instant now() noexcept override { return os::now(); }
};

}  // namespace takt::os
