// Tests whether the system gives a program the rights that it needs for real time, and measures how late the
// system wakes a thread.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cpus.hpp>

namespace takt::os {

/// Statistics of wake-up delays: how long after the requested time a sleeping thread woke up.
struct WakeUps {
  std::size_t count = 0;
  Nanoseconds p50{};
  Nanoseconds p99{};
  Nanoseconds max{};
};
/// Computes the statistics of these delays.
WakeUps wake_ups_of(std::vector<Nanoseconds> delays);

/// Returns the CPUs that executors should use: the isolated CPUs that are permitted or, if there are none,
/// the ordinary CPU with the highest number, which executors without `cpu` get first.
std::vector<int> executor_cpus(const std::vector<int>& isolated, const model::Cpus& cpus);
/// Does the same for this process on this machine. The list is not empty.
std::vector<int> executor_cpus();

/// Starts a thread that sleeps `count` times for `pause` each, and measures how late it wakes up. The thread
/// runs on the last of executor_cpus(). If the system allows it, the thread has SCHED_FIFO, and the CPUs are
/// kept out of deep idle states. Takes a little longer than count x pause.
WakeUps try_wake_ups(std::size_t count, Nanoseconds pause);

struct Trial {
  model::Cpus cpus;
  bool root = false;      ///< true if this program runs as root
  Result<void> priority;  ///< success if SCHED_FIFO is granted
  Result<void> locking;   ///< success if mlockall() can lock present and future memory
  /// The same two rights of takt-node, whose file may have capabilities that this program does not have.
  /// try_machine() does not try them.
  bool node_is_real_time = false;
  std::string node_error{};  ///< why takt-node does not start; empty if it starts
  Result<void> idle_held;    ///< success if /dev/cpu_dma_latency can be opened
  Nanoseconds timer_resolution{};
  /// The largest error of the wall clock, as the kernel estimates it; none if nothing synchronises the clock.
  std::optional<Nanoseconds> wall_clock_error{};
  WakeUps wake_ups;
  std::optional<double> stolen_share{};  ///< share of the CPU time that the hypervisor of this virtual
                                         ///< machine took during the trial, 0 to 1
};
/// Runs all trials. Each trial runs in its own thread or process, which ends with the trial. All trials
/// together take about `moment`, mostly for the wake-ups. The calling process must have only one thread.
Trial try_machine(Nanoseconds moment);

/// Returns the resolution of timers: 1 ns for high-resolution timers, otherwise one tick of the kernel, which
/// lasts several milliseconds. Any thread may call this.
Nanoseconds timer_resolution() noexcept;

}  // namespace takt::os
