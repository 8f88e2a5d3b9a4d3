// What Takt is measured against: a thread that sleeps to the next instant of its grid with clock_nanosleep(),
// as cyclictest does. Nothing else can be told apart from the machine and its load of that minute.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>

namespace takt::bench {

/// A real-time thread's place.
struct Place {
  int cpu = 0;
  int priority = 80;  ///< SCHED_FIFO
};

/// What a loop on a grid has seen.
struct Loop {
  std::vector<std::int64_t> jitter;  ///< ns, Eq. (1): release minus start, one for each cycle in their order
  std::uint64_t missed = 0;          ///< instants of the grid that had passed when the cycle before was over
  Nanoseconds processor_time{};
  Problems refused;  ///< what the system refused, a priority or a processor; it ran all the same

  /// Takes another part of the same measurement in.
  void add(const Loop& other);
};

/// The instants first + n x period, for as long as `length`.
struct Grid {
  Instant first{};
  Nanoseconds period{};
  Nanoseconds length{};

  /// From now on, after a time in which threads can begin.
  static Grid from_now(Nanoseconds period, Nanoseconds length);
  [[nodiscard]] std::size_t instants() const noexcept { return static_cast<std::size_t>(length / period); }
};

/// A cycle at each instant, in the calling thread. `wait` returns the time when it is the given instant or
/// later; `body` is called then with the instant. A late cycle never leaves the grid: the instants that have
/// passed are missed.
Loop loop_on_grid(const Grid& grid, const std::function<Instant(Instant)>& wait,
                  const std::function<void(Instant)>& body = {});

/// clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME); what the bare loop waits with.
Instant sleep_to(Instant release);

/// Runs a loop in a thread of its own at this place. Fails only when there can be no thread.
Result<Loop> run_at(const Place& place, const std::function<Loop()>& loop);

/// The bare loop at this place.
Result<Loop> run_bare_loop(const Place& place, Nanoseconds period, Nanoseconds length);

}  // namespace takt::bench
