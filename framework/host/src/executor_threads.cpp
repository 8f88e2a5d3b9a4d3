#include "executor_threads.hpp"

#include <cstdlib>
#include <new>
#include <utility>

#include <takt/host/host.hpp>
#include <takt/os/environment.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/signals.hpp>
#include <takt/os/waker.hpp>
#include <takt/schedule/levels.hpp>
#include "own_threads.hpp"

namespace takt::host {

namespace {

channel::Crash* crash_place = nullptr;
channel::CheckReporter check_reporter;
thread_local channel::Activity* my_activity = nullptr;
/// In a thread that a module has started: the index of the module, plus 1. Otherwise 0.
thread_local std::uint32_t my_owner = 0;
std::atomic_flag walking_stack;

/// The process that reports its crashes. A module may copy it with fork() or vfork(), and the copy reports
/// nothing.
int reporting_process = 0;

bool reports() noexcept { return crash_place != nullptr && os::process_id() == reporting_process; }

/// Returns the index of the module in whose code the calling thread is, plus 1; 0 if it is in no module.
std::uint32_t module_in_use() noexcept {
  return my_activity != nullptr ? my_activity->module.load(std::memory_order_relaxed) : my_owner;
}

// Stores the module in whose code the calling thread was. Async-signal-safe, because it only stores values.
void store_culprit(int signal) noexcept {
  crash_place->module.store(module_in_use(), std::memory_order_relaxed);
  crash_place->doing.store(
      my_activity != nullptr ? my_activity->doing.load(std::memory_order_relaxed) : channel::Doing::thread,
      std::memory_order_relaxed);
  crash_place->signal.store(signal, std::memory_order_release);
}

void add_frame(const os::CodeAt& place) noexcept {
  const std::uint32_t depth = crash_place->depth.load(std::memory_order_relaxed);
  if (depth >= channel::Crash::kFrames) return;
  crash_place->frames[depth].address = place.address;
  crash_place->frames[depth].object.assign(place.object);
  crash_place->depth.store(depth + 1, std::memory_order_release);  // after the frame is complete
}

// Reports a crash. Stores the culprit first, because walking a broken stack may crash, too, and then
// report_crash() is called again.
void report_crash(int signal, std::uintptr_t at, const char* exception) noexcept {
  if (check_reporter) check_reporter.leave(0);  // the thread never returns to the module
  if (!reports()) return;
  if (exception != nullptr) crash_place->exception.assign(exception);
  store_culprit(signal);
  if (walking_stack.test_and_set(std::memory_order_relaxed)) return;
  os::walk_stack(at, channel::Crash::kFrames, add_frame);
}

void ring(channel::WakeWord& wake_word, std::uint32_t bits) noexcept {
  wake_word.rings.fetch_add(1, std::memory_order_seq_cst);
  os::futex_wake(wake_word.rings, bits);
}

}  // namespace

void ring_pending(channel::WakeWord& wake_word) noexcept {
  if (const std::uint32_t bits = wake_word.take_pending(); bits != 0) ring(wake_word, bits);
}

void report_exit() noexcept {
  if (reports()) store_culprit(channel::Crash::kExit);
}

bool in_module() noexcept { return module_in_use() != 0 && reports(); }

void check_thread_exit() {
  if (my_activity != nullptr && in_module()) throw ThreadExit{};
}

std::unique_ptr<ModuleThread> thread_of_module(void* (*body)(void*), void* argument) noexcept {
  const std::uint32_t owner = module_in_use();
  if (owner == 0) return nullptr;
  return std::unique_ptr<ModuleThread>{new (std::nothrow) ModuleThread{
      .body = body, .argument = argument, .owner = owner, .instance = InInstance::current()}};
}

void* run_thread_of_module(void* thread) {
  const std::unique_ptr<ModuleThread> mine{static_cast<ModuleThread*>(thread)};
  my_owner = mine->owner;
  const InInstance in_instance{mine->instance};
  os::prepare_crash_stack();
  return mine->body(mine->argument);
}

void report_crashes_to(channel::Crash& crash, channel::CheckReporter reporter) {
  crash_place = &crash;
  check_reporter = reporter;
  reporting_process = os::process_id();
  os::on_crash(report_crash);
  // exit() and quick_exit() end the process inside the C library, and do not call its function _exit().
  static_cast<void>(std::atexit(report_exit));
  static_cast<void>(std::at_quick_exit(report_exit));
}

void report_crashes_as(channel::Activity* activity) {
  my_activity = activity;
  activity->thread.store(os::thread_id(), std::memory_order_relaxed);
  os::prepare_crash_stack();
}

ExecutorThreads::ExecutorThreads(const model::Executor& executor, const schedule::ExecutorPlan& plan,
                                 std::vector<executor::Unit> periodic, std::vector<executor::Unit> sporadic,
                                 channel::ExecutorBlock& block, channel::WakeWord& wake_word,
                                 executor::Flight flight)
    : settings_(executor),
      priority_(plan.priority),
      has_rows_(plan.basic_period.count() > 0),
      has_sporadic_(!sporadic.empty()),
      block_(block),
      wake_word_(wake_word),
      executor_(plan, std::move(periodic), std::move(sporadic), block, clock_, flight) {}

ExecutorThreads::~ExecutorThreads() {
  ask_to_halt();
  join();
}

Result<void> ExecutorThreads::begin(Instant t0, const std::vector<int>& cpus, Problems* denied) {
  if (!has_rows_) return {};
  if (has_sporadic_) {
    auto thread = os::Thread::start(
        {.name = settings_.name + "/s", .priority = schedule::sporadic_level(priority_), .cpus = cpus},
        [this] { serve_sporadic(); }, denied);
    if (!thread) return thread.problems();
    sporadic_ = std::move(*thread);
  }
  auto thread = os::Thread::start(
      {.name = settings_.name, .priority = priority_, .cpus = cpus}, [this, t0] { walk_rows(t0); },
      has_sporadic_ ? nullptr : denied);
  if (!thread) return thread.problems();
  rows_ = std::move(*thread);
  return {};
}

void ExecutorThreads::walk_rows(Instant t0) {
  report_crashes_as(&block_.row);
  const Nanoseconds cap = os::margin_cap(executor_.basic_period(), settings_.spin_share);
  os::Waker waker{settings_.wakeup, cap, halt_};
  executor_.join_grid(t0, os::now());
  while (true) {
    const Instant now = waker.wait_until(executor_.next_release());
    if (halt_.load(std::memory_order_relaxed) != 0) return executor_.leave_grid(os::now());
    // Ringing the wake word once wakes both the process modules that the row released and the readers of the
    // samples that the row's modules wrote.
    const std::uint32_t released = reporter_ ? reported_cycle(now) : executor_.run_cycle(now);
    if (const std::uint32_t bits = released | wake_word_.take_pending(); bits != 0) ring(wake_word_, bits);
    block_.margin_ns.store(waker.margin().count(), std::memory_order_relaxed);
  }
}

std::uint32_t ExecutorThreads::reported_cycle(Instant now) noexcept {
  const std::uint64_t before = reporter_.enter(reported_as_, channel::Doing::nothing);
  const std::uint32_t released = executor_.run_cycle(now);
  reporter_.leave(before);
  return released;
}

void ExecutorThreads::serve_sporadic() {
  report_crashes_as(&block_.sporadic);
  while (halt_.load(std::memory_order_seq_cst) == 0) {
    // If another thread rings the wake word after this load, futex_wait() below returns at once. So this
    // thread misses no wake-up.
    const std::uint32_t rings = wake_word_.rings.load(std::memory_order_seq_cst);
    while (halt_.load(std::memory_order_relaxed) == 0 && executor_.run_sporadic()) {
      ring_pending(wake_word_);
    }
    if (halt_.load(std::memory_order_seq_cst) == 0)
      os::futex_wait(wake_word_.rings, rings, channel::kSporadicBit);
  }
}

void ExecutorThreads::ask_to_halt() noexcept {
  halt_.store(1, std::memory_order_seq_cst);
  os::futex_wake(halt_, ~0U);
  ring(wake_word_, channel::kSporadicBit);
}

void ExecutorThreads::join() {
  rows_.join();
  sporadic_.join();
}

}  // namespace takt::host
