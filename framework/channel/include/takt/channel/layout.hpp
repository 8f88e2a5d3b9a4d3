// The layout of the shared memory between a node and its hosts: what the executors publish and the node
// supervises. All zero is its initial state. Each field has one writer at a time, except `in_tables` and
// `error`, which an executor and the node write.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <takt/channel/activity.hpp>
#include <takt/core/fixed_text.hpp>
#include <takt/core/statistics.hpp>

namespace takt::channel {

using Name = FixedText<64>;

/// The block of one module. The module's executor writes it, unless a field says otherwise. The fields that
/// every release touches come first, in as few cache lines as possible: after a sleep these lines are no
/// longer in the CPU's caches, and each one must be fetched.
struct alignas(64) ModuleBlock {
  /// Whether the executor may call or release the module. The node sets and clears it (removal.hpp explains
  /// when a removal is complete). The executor clears it when it raises an error. SYNC: in tables
  std::atomic<std::uint32_t> in_tables;
  /// The ErrorType of an error that the supervisor must handle. The supervisor then resets it to 0. SYNC:
  /// error raised, publishes error_text.
  std::atomic<std::uint32_t> error;
  std::atomic<std::uint64_t> error_cycle;
  std::atomic<std::uint64_t> cycles;  ///< how often the module was called or released
  std::atomic<std::uint64_t>
      missed;  ///< releases that fell into skipped rows while the module was in the tables
  std::atomic<std::uint64_t> overruns;  ///< runs that did not end before the next release or the deadline; a
                                        ///< sporadic program counts its overruns in its release slot
  std::atomic<std::uint64_t> errors;    ///< errors that the executor raised
  std::atomic<std::uint64_t> entered;   ///< how often the node put the module into the tables

  std::atomic<std::uint64_t> over_budget;  ///< runs of a thread module that exceeded the budget
  std::atomic<std::uint32_t> in_a_row;     ///< consecutive runs over budget, up to the last run
  std::atomic<std::uint32_t> on_trial;     ///< 1 while a newly swapped-in instance may still be swapped back

  alignas(64) Statistics jitter;  ///< Eq. (1), P_n - T_n; thread modules only
  alignas(64) Statistics run;     ///< durations of run(); thread modules only

  Activity
      background;    ///< activity of the module's own thread, if the module is a non-real-time thread module
  Activity service;  ///< activity of the thread that calls the module's service handlers
  Name name;
  FixedText<256> error_text;

  /// Asks the CPU to fetch the cache lines that the next release will touch, and does not wait for them. A
  /// real-time thread may call it.
  void prefetch() const noexcept {
    for (const void* line : {static_cast<const void*>(this), static_cast<const void*>(&jitter),
                             static_cast<const void*>(&run)}) {
      __builtin_prefetch(line, 1);
    }
  }
};

struct alignas(64) ExecutorBlock {
  Name name;
  std::atomic<std::uint64_t> cycles;    ///< rows walked
  std::atomic<std::uint64_t> missed;    ///< rows skipped
  std::atomic<std::uint64_t> late;      ///< rows that ended after the next release
  std::atomic<std::uint64_t> next_row;  ///< number of the next row, counted from T0; skipped rows count too
  /// Odd while a row is walked. SYNC: row
  std::atomic<std::uint64_t> row_sequence;
  std::atomic<std::int64_t>
      margin_ns;  ///< how long before a release the executor wakes up; it learns this time
  /// The longest delay from the planned to the actual start of a row, including delays so long that whole
  /// rows were skipped. `jitter` does not show such delays, because it refers only to the rows that were
  /// walked.
  std::atomic<std::int64_t> latest_ns;
  Activity row;       ///< activity of the executor's thread, which walks the rows
  Activity sporadic;  ///< activity of the thread that runs the executor's sporadic modules
  Statistics jitter;  ///< jitter of the start of a row
};

/// A place in the code of a thread that crashed.
struct CrashFrame {
  std::uint64_t address;  ///< address within the file of the loaded object
  FixedText<216> object;  ///< path of this file; empty: the program itself
};

/// What a host records when it crashes, or when a module ends the host with exit().
struct Crash {
  static constexpr std::int32_t kExit = -1;  ///< value of `signal` if a module called exit()
  static constexpr std::size_t kFrames = 32;

  std::atomic<std::int32_t> signal;
  std::atomic<std::uint32_t> module;  ///< index of the module, plus 1; 0: the thread was in no module
  std::atomic<Doing> doing;
  std::atomic<std::uint32_t> depth;        ///< number of `frames` written. SYNC: crash frame
  std::array<CrashFrame, kFrames> frames;  ///< innermost first
};

struct alignas(64) HostBlock {
  std::atomic<std::int64_t> t0_ns;  ///< T0 of all executors; 0 until T0 is agreed
  Activity hooks;                   ///< activity of the thread that calls hooks
  Activity swap;                    ///< activity of the thread that prepares an instance for a swap
  Crash crash;
};

}  // namespace takt::channel
