// The machine's monotonic clock.
#pragma once

#include <ctime>

#include <takt/core/clock.hpp>
#include <takt/core/time.hpp>

namespace takt::os {

/// CLOCK_MONOTONIC through the vDSO: about 20 ns, no system call where the clock source is the TSC. Any
/// thread.
inline Instant now() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return from_ns(static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec);
}

/// Sleeps until an absolute instant; signals do not shorten it. Returns at once if it has passed. One system
/// call.
void sleep_until(Instant instant) noexcept;

/// The clock that an executor reads when it runs for real.
class MonotonicClock final : public Clock {
 public:
  Instant now() noexcept override { return os::now(); }
};

}  // namespace takt::os
