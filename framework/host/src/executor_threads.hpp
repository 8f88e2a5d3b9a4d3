// The threads of an executor. One thread runs the rows at absolute times, and the other runs the sporadic
// modules. The sporadic thread runs on the same CPU with a lower priority, so that the next row preempts it.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <takt/channel/check_reporter.hpp>
#include <takt/channel/layout.hpp>
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
  /// Allocates everything that the threads use. begin() starts the threads.
  ExecutorThreads(const model::Executor& executor, const schedule::ExecutorPlan& plan,
                  std::vector<executor::Unit> periodic, std::vector<executor::Unit> sporadic,
                  channel::ExecutorBlock& block, channel::WakeWord& wake_word, executor::Flight flight = {});
  /// Halts the threads and waits for them to end.
  ~ExecutorThreads();

  /// From now on, the thread of the rows reports to `reporter` when it runs code of the executor itself,
  /// between the calls of modules. `index` is the index of the executor. Call report_to() before begin().
  void report_to(channel::CheckReporter reporter, std::uint32_t index) noexcept {
    reporter_ = reporter;
    reported_as_ = channel::kOfExecutor | index;
  }

  /// Starts the threads on the grid that begins at `t0`. If the system denies a priority or a CPU, the
  /// threads run without it, and a problem is added to `denied`. Fails if a thread cannot be created.
  Result<void> begin(Instant t0, const std::vector<int>& cpus, Problems* denied);
  /// Asks the thread of the rows to end after its current row, and the sporadic thread after its current
  /// module.
  void ask_to_halt() noexcept;
  /// Requests an exchange of the instance of one of this executor's modules; see executor::Executor.
  void exchange(executor::Exchange& exchange) noexcept { executor_.exchange(exchange); }
  bool withdraw() noexcept { return executor_.withdraw(); }
  /// Waits for the threads to end. Never returns if a module never returns.
  void join();

 private:
  void walk_rows(Instant t0);
  std::uint32_t reported_cycle(Instant now) noexcept;
  void serve_sporadic();

  model::Executor settings_;
  int priority_;
  bool has_rows_;
  bool has_sporadic_;
  channel::ExecutorBlock& block_;
  channel::WakeWord& wake_word_;
  os::MonotonicClock clock_;
  executor::Executor executor_;
  channel::CheckReporter reporter_;
  std::uint32_t reported_as_ = 0;
  std::atomic<std::uint32_t> halt_{0};
  os::Thread rows_;
  os::Thread sporadic_;
};

/// Wakes the readers that wait for samples written since the last call. A real-time thread may call this,
/// because it makes at most one system call, and none if no reader waits.
void ring_pending(channel::WakeWord& wake_word) noexcept;

/// Sets the activity that the crash report names if the calling thread crashes or hangs. Stores the id of the
/// thread in the activity.
void report_crashes_as(channel::Activity* activity);
/// True if the calling thread is in a hook, or was started by a module. False in a copy of this process that
/// a module made by fork(). Async-signal-safe.
bool in_module() noexcept;

/// What pthread_exit() throws in a hook.
class ThreadExit final : public std::exception {
 public:
  [[nodiscard]] const char* what() const noexcept override {
    return "it called pthread_exit() in a thread of the host; return from the hook instead";
  }
};

/// From now on, modules cannot close the file descriptors that are open now (see protects()).
void protect_descriptors();

/// From now on, a crash of any thread of this process is stored in `crash`. The crash handler's own system
/// calls are not reported to `reporter` as violations of the module.
void report_crashes_to(channel::Crash& crash, channel::CheckReporter reporter);

}  // namespace takt::host
