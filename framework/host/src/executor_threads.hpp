// The threads of an executor. One walks its rows on absolute time, the other runs its sporadic modules. The
// sporadic thread runs on the same CPU with a priority lower by one, so that the next row preempts it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <takt/channel/layout.hpp>
#include <takt/channel/module_watch.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/channel/violations.hpp>
#include <takt/core/result.hpp>
#include <takt/executor/executor.hpp>
#include <takt/model/cell.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/real_time.hpp>

namespace takt::host {

class ExecutorThreads {
 public:
  /// Allocates everything that the threads use.
  ExecutorThreads(const model::Executor& executor, const schedule::ExecutorPlan& plan,
                  std::vector<executor::Unit> periodic, std::vector<executor::Unit> sporadic,
                  channel::ExecutorBlock& block, channel::WakeWord& wake_word, executor::Flight flight = {});
  /// Halts the threads.
  ~ExecutorThreads();

  /// Makes `watch` also observe the threads between two modules, under this executor index. Call it before
  /// begin().
  void watch(channel::ModuleWatch watch, std::uint32_t index) noexcept {
    watch_ = watch;
    watched_as_ = channel::kOfExecutor | index;
  }

  /// Starts the threads on the grid that begins at `t0`. If the system denies a priority or a CPU, a problem
  /// is added to `denied` and the threads run without it. Fails if a thread cannot be created.
  Result<void> begin(Instant t0, const std::vector<int>& cpus, Problems* denied);
  /// Asks the threads to end after the current row or module.
  void ask_to_halt() noexcept;
  /// Exchanges the instance of a module of this executor; see executor::Executor.
  void exchange(executor::Exchange& exchange) noexcept { executor_.exchange(exchange); }
  bool withdraw() noexcept { return executor_.withdraw(); }
  /// Waits for the threads to end. Never returns if a module never returns.
  void join();

 private:
  void walk_rows(Instant t0);
  std::uint32_t watched_cycle(Instant now) noexcept;
  void serve_sporadic();

  model::Executor settings_;
  int priority_;
  bool has_rows_;
  bool has_sporadic_;
  channel::ExecutorBlock& block_;
  channel::WakeWord& wake_word_;
  os::MonotonicClock clock_;
  executor::Executor executor_;
  channel::ModuleWatch watch_;
  std::uint32_t watched_as_ = 0;
  std::atomic<std::uint32_t> halt_{0};
  os::Thread rows_;
  os::Thread sporadic_;
};

/// Wakes the readers that wait for samples written since the last call. A real-time thread may call it: it
/// makes one system call, or none if no reader waits.
void ring_pending(channel::WakeWord& wake_word) noexcept;

/// Sets the activity that the crash report names if the calling thread crashes.
void report_crashes_as(const channel::Activity* activity);
/// From now on, a crash of any thread is reported in `crash`.
void report_crashes_to(channel::Crash& crash);

}  // namespace takt::host
