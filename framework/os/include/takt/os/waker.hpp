// Wakes a thread at an instant. A wake-up from sleep is the largest timing error of a control loop: tens of
// microseconds in a virtual machine, several on bare metal. So the thread sleeps until a margin before the
// instant and then spins.
#pragma once

#include <atomic>
#include <cstdint>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::os {

/// The time by which the sleep ends before the instant. It is the 99th percentile of the observed wake-up
/// delays, tracked in one number. Pure: reads no clock.
class WakeMargin {
 public:
  /// The margin starts at its cap, so that the first wake-ups are early rather than late.
  explicit WakeMargin(Nanoseconds cap) noexcept : cap_ns_(cap.count()), margin_ns_(cap.count()) {}

  /// Records that a sleep ended this much too late.
  void observe(Nanoseconds delay) noexcept;
  [[nodiscard]] Nanoseconds value() const noexcept { return Nanoseconds{margin_ns_}; }

 private:
  std::int64_t cap_ns_;
  std::int64_t margin_ns_;
};

/// The maximum margin for a period: this share of it (0 to 1), but at most 100 us.
Nanoseconds margin_cap(Nanoseconds period, double share) noexcept;

/// Waits for releases with one of three strategies:
/// - `sleep` sleeps until the instant,
/// - `hybrid` sleeps, then spins,
/// - `spin` never sleeps and uses a whole CPU; the kernel's real-time throttling interrupts it unless that is
/// off.
class Waker {
 public:
  /// `stop` ends a wait early when it becomes non-zero; the thread that sets it must also wake it (futex).
  /// `cap` is the maximum margin, see margin_cap(); `sleep` does not use it.
  Waker(model::Wakeup strategy, Nanoseconds cap, const std::atomic<std::uint32_t>& stop) noexcept
      : strategy_(strategy), stop_(stop), margin_(strategy == model::Wakeup::sleep ? Nanoseconds{0} : cap) {}

  /// Waits until `release` or until `stop` ends the wait. Returns the time at which the wait ended. Returns
  /// at once if `release` has passed. Real-time; at most one system call, its sleep.
  Instant wait_until(Instant release) noexcept;

  /// The present margin: 0 for `sleep`, without meaning for `spin`. Only the waiting thread may call it.
  [[nodiscard]] Nanoseconds margin() const noexcept { return margin_.value(); }

 private:
  model::Wakeup strategy_;
  const std::atomic<std::uint32_t>& stop_;
  WakeMargin margin_;
};

/// Hints to the CPU that this thread spins.
inline void cpu_relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace takt::os
