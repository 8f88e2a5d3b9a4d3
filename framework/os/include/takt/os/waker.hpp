// Waking up at an instant. A wake-up from sleep is the largest error of a control loop: tens of microseconds
// in a virtual machine, several on metal. So the thread sleeps to a margin before the instant and spins the
// rest.
#pragma once

#include <atomic>
#include <cstdint>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::os {

/// How long before an instant to end the sleep: the 99th percentile of the wake-up delays seen, tracked in
/// one number. Pure: no clock.
class WakeMargin {
 public:
  /// The margin starts at its cap, so that the first wake-ups are early rather than late.
  explicit WakeMargin(Nanoseconds cap) noexcept : cap_ns_(cap.count()), margin_ns_(cap.count()) {}

  /// A sleep ended this long after it should have.
  void observe(Nanoseconds delay) noexcept;
  [[nodiscard]] Nanoseconds value() const noexcept { return Nanoseconds{margin_ns_}; }

 private:
  std::int64_t cap_ns_;
  std::int64_t margin_ns_;
};

/// The largest margin for a period: this share of it, 0 to 1, and at most 100 us.
Nanoseconds margin_cap(Nanoseconds period, double share) noexcept;

/// Waits for releases by one of three strategies: `sleep` (sleep to the instant), `hybrid` (sleep, then
/// spin), `spin` (never sleep: one core at 100 %, which the kernel's real-time throttling interrupts unless
/// it is off).
class Waker {
 public:
  /// `stop` ends a wait early when it is not 0; who sets it wakes it (futex).
  /// `cap`: see margin_cap(); not used by `sleep`.
  Waker(model::Wakeup strategy, Nanoseconds cap, const std::atomic<std::uint32_t>& stop) noexcept
      : strategy_(strategy), stop_(stop), margin_(strategy == model::Wakeup::sleep ? Nanoseconds{0} : cap) {}

  /// Real-time. Returns the time at which it ended, not before `release` unless stopped; at once if that has
  /// passed. One system call at most, its sleep.
  Instant wait_until(Instant release) noexcept;

  /// 0 for `sleep`; for `spin` without meaning. Any thread may not call it: it belongs to the waiting thread.
  [[nodiscard]] Nanoseconds margin() const noexcept { return margin_.value(); }

 private:
  model::Wakeup strategy_;
  const std::atomic<std::uint32_t>& stop_;
  WakeMargin margin_;
};

/// Tells the processor that this thread spins.
inline void cpu_relax() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace takt::os
