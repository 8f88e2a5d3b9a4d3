// The reference for Takt: a thread that sleeps to the next instant of its grid with clock_nanosleep(), as
// cyclictest does. Only with such a reference can Takt's jitter be separated from that of the machine and its
// load.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::bench {

/// The CPU and priority of a real-time thread.
struct Place {
  int cpu = 0;
  int priority = 80;  ///< SCHED_FIFO
};

/// The measurements of a loop on a grid.
struct Loop {
  std::vector<std::int64_t> jitter;  ///< ns, Eq. (1): release minus start, for each cycle in order
  std::uint64_t missed = 0;          ///< instants of the grid that had passed when the previous cycle ended
  Nanoseconds cpu_time{};
  Problems refused;  ///< a priority or a CPU that the system denied; the loop ran without it

  /// Adds another part of the same measurement.
  void add(const Loop& other);
};

/// The instants first + n x period, during `length`.
struct Grid {
  Instant first{};
  Nanoseconds period{};
  Nanoseconds length{};

  /// A grid that begins after a short time, in which threads can start.
  static Grid from_now(Nanoseconds period, Nanoseconds length);
  [[nodiscard]] std::size_t instants() const noexcept { return static_cast<std::size_t>(length / period); }
};

/// Runs a cycle at each instant, in the calling thread. `wait` waits for the given instant and returns the
/// time; then `body` is called with the instant. A late cycle keeps the grid: the instants that have passed
/// count as missed.
Loop loop_on_grid(const Grid& grid, const std::function<Instant(Instant)>& wait,
                  const std::function<void(Instant)>& body = {});

/// Waits with clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME), as the bare loop does.
Instant sleep_to(Instant release);

/// Runs a loop in its own thread at this place. Fails only if the thread cannot be created.
Result<Loop> run_at(const Place& place, const std::function<Loop()>& loop);

/// Runs the bare loop at this place.
Result<Loop> run_bare_loop(const Place& place, Nanoseconds period, Nanoseconds length);

}  // namespace takt::bench
