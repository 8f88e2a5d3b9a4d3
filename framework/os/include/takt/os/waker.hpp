// Lets a thread wait until a given time. The delay of a wake-up from sleep is the largest timing error of a
// control loop: tens of microseconds in a virtual machine, a few microseconds on a physical machine. So the
// thread sleeps until shortly before the given time, and then spins. The time from the planned end of the
// sleep to the given time is called the margin.
#pragma once

#include <atomic>
#include <cstdint>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::os {

/// Chooses the margin. The margin follows the 99th percentile of the observed wake-up delays. Reads no clock.
class WakeMargin {
 public:
  /// The margin begins at its maximum `cap`, so that the first waits end in time.
  explicit WakeMargin(Nanoseconds cap) noexcept : cap_ns_(cap.count()), margin_ns_(cap.count()) {}

  /// Records how much later than planned a sleep ended.
  void observe(Nanoseconds delay) noexcept;
  [[nodiscard]] Nanoseconds value() const noexcept { return Nanoseconds{margin_ns_}; }

 private:
  std::int64_t cap_ns_;
  std::int64_t margin_ns_;
};

/// Returns the maximum margin for a period: `share` (0 to 1) of the period, but at most 100 us.
Nanoseconds margin_cap(Nanoseconds period, double share) noexcept;

/// Waits for releases with one of three strategies:
/// - `sleep` sleeps until the release,
/// - `hybrid` sleeps until shortly before the release, then spins,
/// - `spin` never sleeps and uses a whole CPU; the kernel's throttling, if it is on, interrupts the thread.
class Waker {
 public:
  /// If another thread sets `stop` to a value other than 0 and then calls futex_wake() on it, a wait ends
  /// early. `cap` is the maximum margin, see margin_cap(); the strategy `sleep` does not use it.
  Waker(model::Wakeup strategy, Nanoseconds cap, const std::atomic<std::uint32_t>& stop) noexcept
      : strategy_(strategy), stop_(stop), margin_(strategy == model::Wakeup::sleep ? Nanoseconds{0} : cap) {}

  /// Waits until `release`, or until `stop` ends the wait. Returns the time at which the wait ended. Returns
  /// at once if `release` has passed. Real-time threads may call this; it makes at most one system call, for
  /// the sleep.
  Instant wait_until(Instant release) noexcept;

  /// Returns the present margin. It is 0 for `sleep`, and has no meaning for `spin`. Only the waiting thread
  /// may call this function.
  [[nodiscard]] Nanoseconds margin() const noexcept { return margin_.value(); }

 private:
  model::Wakeup strategy_;
  const std::atomic<std::uint32_t>& stop_;
  WakeMargin margin_;
};

/// Tells the CPU that this thread is spinning.
inline void cpu_relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace takt::os
