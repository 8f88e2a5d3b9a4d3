// The shared memory between a node and its host: what the executors publish and the node supervises. All zero
// is its initial state; every field has one writer at a time.
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

/// Written by the executor that the module belongs to, unless said otherwise. What it touches each release
/// comes first in as few cache lines as that takes: after a sleep they are no longer in its caches, and each
/// is waited for.
struct alignas(64) ModuleBlock {
  /// Whether the executor may call or release it. Set and cleared by the node (removal.hpp says when the
  /// module is out then); cleared by the executor when it raises an error. SYNC: in tables
  std::atomic<std::uint32_t> in_tables;
  /// An ErrorType that waits for the supervisor, which sets it back to 0. SYNC: error raised, publishes
  /// error_text.
  std::atomic<std::uint32_t> error;
  std::atomic<std::uint64_t> error_cycle;
  std::atomic<std::uint64_t> cycles;    ///< times it was called or released
  std::atomic<std::uint64_t> missed;    ///< releases in rows that were skipped while it was in the tables
  std::atomic<std::uint64_t> overruns;  ///< not done by its next release, or by its deadline; a sporadic
                                        ///< program counts its own, in its slot
  std::atomic<std::uint64_t> errors;    ///< raised by the executor
  std::atomic<std::uint64_t> entered;   ///< times that the node put it into the tables

  std::atomic<std::uint64_t> over_budget;  ///< runs of a thread module that took longer
  std::atomic<std::uint32_t> in_a_row;     ///< of these, the last without a shorter one between
  std::atomic<std::uint32_t> on_trial;     ///< 1 while an instance that was swapped in may still be put back

  alignas(64) Statistics jitter;  ///< Eq. (1), P_n - T_n; of thread modules
  alignas(64) Statistics run;     ///< of thread modules

  Activity background;  ///< of the thread of a non-real-time thread module
  Activity service;     ///< of the thread that calls its handlers
  Name name;
  FixedText<256> error_text;

  /// Real-time. Asks for the lines that the next release will touch, while something else is done.
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
  std::atomic<std::uint64_t> next_row;  ///< counted from T0, with a gap for every row missed
  /// Odd while a row is walked. SYNC: row
  std::atomic<std::uint64_t> row_sequence;
  std::atomic<std::int64_t> margin_ns;  ///< of the wake-up, as learned
  /// The longest time from a row's instant to its beginning, also where that cost whole rows, which `jitter`
  /// does not show: it is of the row that was walked.
  std::atomic<std::int64_t> latest_ns;
  Activity row;       ///< of the executor's thread
  Activity sporadic;  ///< of the thread of its sporadic modules
  Statistics jitter;  ///< of the row's start
};

/// A place in the code of a thread that crashed.
struct CrashFrame {
  std::uint64_t address;  ///< as the file that it was loaded from counts
  FixedText<216> object;  ///< this file; empty: the program itself
};

/// The last words of a host that crashed, or was ended by a module that called exit().
struct Crash {
  static constexpr std::int32_t kExit = -1;  ///< it called exit()
  static constexpr std::size_t kFrames = 32;

  std::atomic<std::int32_t> signal;
  std::atomic<std::uint32_t> module;  ///< its index + 1; 0: none was running in that thread
  std::atomic<Doing> doing;
  std::atomic<std::uint32_t> depth;        ///< of `frames` that are written. SYNC: crash frame
  std::array<CrashFrame, kFrames> frames;  ///< innermost first
};

struct alignas(64) HostBlock {
  std::atomic<std::int64_t> t0_ns;  ///< T0 of all executors; 0 before the first row is agreed
  Activity hooks;                   ///< of the thread that calls hooks
  Activity swap;                    ///< of the thread that prepares an instance to be swapped in
  Crash crash;
};

}  // namespace takt::channel
