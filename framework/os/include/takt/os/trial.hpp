// Checks whether the system allows a program what it needs for real time, and measures how late the system
// wakes a thread.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::os {

/// Statistics of wake-up delays: how long after the requested time a sleeping thread woke up.
struct WakeUps {
  std::size_t count = 0;
  Nanoseconds p50{};
  Nanoseconds p99{};
  Nanoseconds max{};
};
/// Computes the statistics of the given delays. Pure function.
WakeUps wake_ups_of(std::vector<Nanoseconds> delays);

/// Measures the delays of a new thread that sleeps `count` times for `pause` each. The thread runs on the
/// highest CPU that this process may use. If the system allows it, the thread has SCHED_FIFO, and the CPUs
/// are kept out of deep idle states. Takes a little longer than count x pause.
WakeUps try_wake_ups(std::size_t count, Nanoseconds pause);

struct Trial {
  Result<void> priority;   ///< SCHED_FIFO
  Result<void> locking;    ///< whether mlockall() can lock present and future memory
  Result<void> idle_held;  ///< /dev/cpu_dma_latency
  Nanoseconds timer_resolution{};
  WakeUps wake_ups;
  std::optional<double> stolen_share{};  ///< share of the CPU time that the host of this virtual machine took
                                         ///< during the trial, 0 to 1
};
/// Runs all trials. Each one runs in its own thread or process, which ends with the trial. Most of the time,
/// which is about `moment`, is spent on the wake-ups. The caller must have only one thread.
Trial try_machine(Nanoseconds moment);

/// The resolution of timers: 1 ns for high-resolution timers, otherwise one tick of the kernel, which is
/// several milliseconds long. Any thread may call this.
Nanoseconds timer_resolution() noexcept;

}  // namespace takt::os
