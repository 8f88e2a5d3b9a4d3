// Another instance of a module takes the place of the one that runs, without a missed release: `takt swap`.
//
// Whatever takes long or may fail is done before, beside the rows: loading, comparing, initialize(),
// restore(), start(). What is left is one exchange between two rows (executor/exchange.hpp), in which the
// executor's thread hands over what was saved last, so nothing that the old instance counted meanwhile is
// lost. Only what is of another version must be translated by the component, which no real-time thread can
// wait for: it is translated right after a run() and taken if nothing was saved since, else once more.
#pragma once

#include <cstdint>
#include <functional>
#include <mutex>
#include <string>

#include <takt/module.h>
#include <takt/channel/layout.hpp>
#include <takt/core/result.hpp>
#include <takt/host/thread_module.hpp>
#include "executor_threads.hpp"

namespace takt::host {

/// Runs of a new instance in which an error puts the old one back.
inline constexpr std::uint64_t kTrialRuns = 10;

struct Swap {
  std::uint32_t index;  ///< of the module on its device
  const channel::ModuleBlock& block;
  ThreadModule& before;                                   ///< that runs
  ThreadModule& next;                                     ///< attached, not loaded
  executor::Body& body;                                   ///< as which the executor calls `next`
  ExecutorThreads& threads;                               ///< of its executor
  channel::SavedState& place;                             ///< where the module saves
  channel::Activity& activity;                            ///< of the calling thread, which is not real-time
  std::string path;                                       ///< of `next`
  irp::Property::Values properties;                       ///< that are in force
  std::function<Result<void>()> connect;                  ///< ties the ports of `next` to its links
  std::function<std::unique_lock<std::mutex>()> exclude;  ///< no handler is called while this is held
  std::function<void(ThreadModule&)> handle_by;           ///< whose handlers are called from now on
  std::function<bool()> ends;  ///< the executors have halted, or nobody waits for us any more
};

struct Swapped {
  bool kept = false;
  std::string text;  ///< since when; or why not
};

/// Waits for the exchange and the trial. Where it is not kept, `before` runs on with what it saved itself.
Swapped carry_out(const Swap& swap);

}  // namespace takt::host
