// The bare loop, which is the reference for Takt: a thread that sleeps until the next instant of its grid
// with clock_nanosleep(), as cyclictest does. The reference shows which part of the measured jitter comes
// from the machine and its load, and not from Takt.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::bench {

/// The CPU and the priority of a real-time thread.
struct Scheduling {
  int cpu = 0;
  int priority = 80;  ///< priority under SCHED_FIFO
};

/// The measurements of a loop that runs a cycle at each instant of a grid.
struct Loop {
  std::vector<std::int64_t> jitter;  ///< jitter of each cycle in ns, Eq. (1): release minus start
  std::uint64_t missed = 0;          ///< number of instants that had passed when the previous cycle ended
  Nanoseconds cpu_time{};
  Problems refused;  ///< reports that the system denied the priority or the CPU; the loop ran nevertheless

  /// Adds `other`, the results of a further part of the same measurement.
  void add(const Loop& other);
};

/// A time grid: the instants first + n x period, for n = 0, 1, ..., within `length`.
struct Grid {
  Instant first{};
  Nanoseconds period{};
  Nanoseconds length{};

  /// A grid that begins shortly after now, so that threads have time to start.
  static Grid from_now(Nanoseconds period, Nanoseconds length);
  [[nodiscard]] std::size_t instants() const noexcept { return static_cast<std::size_t>(length / period); }
};

/// Runs a cycle at each instant of the grid, in the calling thread: `wait` waits for the instant and returns
/// the current time, then `body` is called with the instant. After a late cycle, the loop keeps its grid: the
/// instants that have passed count as missed.
Loop loop_on_grid(const Grid& grid, const std::function<Instant(Instant)>& wait,
                  const std::function<void(Instant)>& body = {});

/// Waits like the bare loop, with clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME). Returns the time after the
/// wake-up.
Instant sleep_to(Instant release);

/// Runs a loop in a new thread with this CPU and priority. Fails only if the thread cannot be created.
Result<Loop> run_at(const Scheduling& scheduling, const std::function<Loop()>& loop);

/// Runs the bare loop in a new thread with this CPU and priority.
Result<Loop> run_bare_loop(const Scheduling& scheduling, Nanoseconds period, Nanoseconds length);

}  // namespace takt::bench
