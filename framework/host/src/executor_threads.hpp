// The threads that an executor runs on: one that walks its rows on absolute time, and one for its sporadic
// modules, one priority lower on the same processor, so that the next row preempts them.
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
  /// Allocates everything that the threads will use.
  ExecutorThreads(const model::Executor& executor, const schedule::ExecutorPlan& plan,
                  std::vector<executor::Unit> periodic, std::vector<executor::Unit> sporadic,
                  channel::ExecutorBlock& block, channel::WakeWord& wake_word, executor::Flight flight = {});
  /// Halts.
  ~ExecutorThreads();

  /// What the threads do between modules is watched too, as that of the executor with this index. Before
  /// begin().
  void watch(channel::ModuleWatch watch, std::uint32_t index) noexcept {
    watch_ = watch;
    watched_as_ = channel::kOfExecutor | index;
  }

  /// Starts on the grid of T0. What the system refuses (priority, processor) is added to `refused`; the
  /// threads run all the same. Fails when a thread cannot be created.
  Result<void> begin(Instant t0, const std::vector<int>& cpus, Problems* refused);
  /// Tells the threads to end, after the row or the module that they are in.
  void ask_to_halt() noexcept;
  /// For modules of this executor; as executor::Executor has them.
  void exchange(executor::Exchange& exchange) noexcept { executor_.exchange(exchange); }
  bool withdraw() noexcept { return executor_.withdraw(); }
  /// Waits for them; a module that never returns keeps them for ever.
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

/// Rings for whoever waits for what was written since it was done last. Real-time: one system call at most,
/// and none where nobody waits.
void ring_pending(channel::WakeWord& wake_word) noexcept;

/// Names the activity of the calling thread for the report of a crash.
void report_crashes_as(const channel::Activity* activity);
/// Makes a crash of any thread leave its last words there.
void report_crashes_to(channel::Crash& crash);

}  // namespace takt::host
