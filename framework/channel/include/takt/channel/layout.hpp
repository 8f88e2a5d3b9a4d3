// The layout of the shared memory between a node and its hosts: the data that the executors publish and the
// node supervises. Initially all bytes are zero. Each field has one writer at a time, except `in_tables` and
// `error`, which the node, an executor and background threads of the host write.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

#include <takt/channel/activity.hpp>
#include <takt/channel/log_ring.hpp>
#include <takt/core/fixed_text.hpp>
#include <takt/core/statistics.hpp>

namespace takt::channel {

using Name = FixedText<64>;

/// The block of one module. The module's executor writes the block, unless a field says otherwise. The fields
/// that every release touches come first, in as few cache lines as possible: after a sleep of the executor
/// these lines are no longer in the CPU's caches, and the CPU must fetch each one from memory.
struct alignas(64) ModuleBlock {
  /// 1 while the executor may call or release the module, otherwise 0. The node sets and clears this word
  /// (removal.hpp explains when a removal is complete). The executor also clears it, when it raises an error
  /// and after the module's last run.
  std::atomic<std::uint32_t> in_tables;
  /// The ErrorType of an error that the supervisor must handle. The supervisor then resets this word to 0.
  /// The writer stores this word after `error_text`, so a reader that sees the error also sees its text.
  std::atomic<std::uint32_t> error;
  std::atomic<std::uint64_t> error_cycle;
  std::atomic<std::uint64_t> cycles;  ///< number of times that the module was called or released
  std::atomic<std::uint64_t>
      missed;  ///< releases that fell into skipped rows while the module was in the tables
  std::atomic<std::uint64_t> overruns;  ///< runs that did not end before the next release or the deadline; a
                                        ///< sporadic program counts its overruns in its release slot
  std::atomic<std::uint64_t> errors;    ///< errors that the executor raised
  std::atomic<std::uint64_t> entered;   ///< number of times that the node put the module into the tables

  std::atomic<std::uint64_t> over_budget;  ///< number of runs of a thread module that exceeded the budget
  std::atomic<std::uint32_t> in_a_row;     ///< number of runs in a row, up to the last one, that exceeded the
                                           ///< budget
  std::atomic<std::uint32_t> on_trial;     ///< 1 while a newly swapped-in instance may still be swapped back
  /// 1 after run() has reported that the module has finished, or after the program of a process module has
  /// ended with status 0. The node resets this word to 0.
  std::atomic<std::uint32_t> finished;

  alignas(64) Statistics jitter;  ///< jitter of thread modules: P_n - T_n of the paper's Eq. (1)
  alignas(64) Statistics run;     ///< durations of run(); only for thread modules

  Activity
      background;    ///< activity of the module's own thread, if the module is a non-real-time thread module
  Activity service;  ///< activity of the thread that calls the module's service handlers
  Name name;
  FixedText<256> error_text;
  LogRing log;  ///< the log of a thread module; the host's threads that call the module's hooks write it

  /// Asks the CPU to fetch the cache lines that the next release will touch. Does not wait for these lines. A
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
  std::atomic<std::uint64_t> cycles;    ///< number of executed rows
  std::atomic<std::uint64_t> missed;    ///< number of skipped rows
  std::atomic<std::uint64_t> late;      ///< number of rows that ended after the next row was due
  std::atomic<std::uint64_t> next_row;  ///< number of the next row, counted from T0; skipped rows count too
  /// Odd while the executor executes a row. The executor increments this number when a row begins and when it
  /// ends.
  std::atomic<std::uint64_t> row_sequence;
  std::atomic<std::int64_t>
      margin_ns;  ///< time before a row at which the executor wakes up; the executor adapts this time
  /// The longest delay from the planned to the actual start of a row, including delays so long that whole
  /// rows were skipped. `jitter` lacks such delays, because it refers only to the rows that were executed.
  std::atomic<std::int64_t> latest_ns;
  Activity row;       ///< activity of the executor's thread, which executes the rows
  Activity sporadic;  ///< activity of the thread that runs the executor's sporadic modules
  Statistics jitter;  ///< jitter of the start of a row
};

/// A frame of the call stack of a thread that crashed or hung.
struct CrashFrame {
  std::uint64_t address;  ///< relative to the load address of the object, as in its symbol table
  FixedText<216> object;  ///< path of the loaded object (a library); empty: the program itself
};

/// What a host records when it crashes, when the node ends it because a thread hangs, or when a module ends
/// the host with exit(), quick_exit() or _exit().
struct Crash {
  static constexpr std::int32_t kExit = -1;  ///< value of `signal` if a module called one of these
  static constexpr std::size_t kFrames = 32;

  std::atomic<std::int32_t> signal;
  std::atomic<std::uint32_t> module;  ///< index of the module whose hook was running, plus 1; 0: none
  std::atomic<Doing> doing;
  FixedText<256> exception;          ///< text of the exception that ended the host; empty if there was none
  std::atomic<std::uint32_t> depth;  ///< number of complete `frames`
  std::array<CrashFrame, kFrames> frames;  ///< innermost first
};

struct alignas(64) HostBlock {
  std::atomic<std::int64_t> t0_ns;  ///< T0 of all executors; 0 until T0 is agreed
  Activity hooks;                   ///< activity of the thread that calls hooks
  Activity swap;                    ///< activity of the thread that prepares an instance for a swap
  Crash crash;
};

}  // namespace takt::channel
