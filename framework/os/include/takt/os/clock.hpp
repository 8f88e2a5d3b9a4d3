// The monotonic clock and the wall clock of the machine.
#pragma once

#include <cstdint>
#include <ctime>

#include <takt/core/clock.hpp>
#include <takt/core/time.hpp>

namespace takt::os {

/// Returns the time of CLOCK_MONOTONIC. If the clock source is the TSC, this takes about 20 ns and no system
/// call, because the time is read through the vDSO. Any thread may call this, even a real-time thread.
inline Instant now() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return from_ns(static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec);
}

/// Returns the time of CLOCK_BOOTTIME, which also counts while the machine is suspended.
inline Instant boot_time() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_BOOTTIME, &t);
  return from_ns(static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec);
}

/// Returns the wall clock in nanoseconds since 1970 (UTC). The wall clock may jump, because it can be set.
std::int64_t wall_ns() noexcept;
/// Returns the monotonic time at which the wall clock will show `wall_ns`, unless somebody sets the wall
/// clock before then. Accurate to about a microsecond, even on a busy machine.
Instant instant_of_wall(std::int64_t wall_ns) noexcept;

/// Sleeps until this time; signals do not end the sleep. Returns at once if the time has passed. Makes one
/// system call.
void sleep_until(Instant instant) noexcept;

/// The machine's clock, as executors use it. Simulations and tests use other clocks.
class MonotonicClock final : public Clock {
 public:
  Instant now() noexcept override { return os::now(); }
};

}  // namespace takt::os
