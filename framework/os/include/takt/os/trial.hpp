// Tries whether the system grants what real time needs, and measures how late it wakes a thread.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::os {

/// How late a thread woke up after sleeping until an instant.
struct WakeUps {
  std::size_t count = 0;
  Nanoseconds p50{};
  Nanoseconds p99{};
  Nanoseconds max{};
};
/// Computes the statistics of these delays. Pure.
WakeUps wake_ups_of(std::vector<Nanoseconds> delays);

/// Lets a new thread sleep `count` times for `pause` each, on the highest CPU that this process may use. If
/// the system allows it, the thread has SCHED_FIFO and deep idle states are prevented. Takes a little longer
/// than count x pause.
WakeUps try_wake_ups(std::size_t count, Nanoseconds pause);

struct Trial {
  Result<void> priority;   ///< SCHED_FIFO
  Result<void> locking;    ///< mlockall of present and future memory
  Result<void> idle_held;  ///< /dev/cpu_dma_latency
  Nanoseconds timer_resolution{};
  WakeUps wake_ups;
  std::optional<double> stolen_share{};  ///< by the host of this virtual machine meanwhile, 0 to 1
};
/// Tries everything. Each trial runs on a thread or in a process of its own, which ends with the trial. Takes
/// the time `moment`, most of it for the wake-ups. The caller must have a single thread.
Trial try_machine(Nanoseconds moment);

/// 1 ns if timers have a high resolution, else one tick of the kernel, which takes milliseconds. Any thread
/// may call it.
Nanoseconds timer_resolution() noexcept;

}  // namespace takt::os
