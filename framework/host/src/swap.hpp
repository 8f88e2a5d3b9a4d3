// Replaces a running module by a new instance without a missed release: `takt swap`.
//
// All steps that are slow or can fail happen first, while the rows continue: loading, comparing,
// initialize(), restore() and start(). Then one exchange happens between two rows (executor/exchange.hpp).
// During the exchange, the executor's thread hands over the state that was saved last. So the new instance
// misses no update of the old instance.
//
// If the two instances save different versions of the state, restore() of the new instance must translate the
// state, and a real-time thread cannot wait for restore(). So a background thread calls restore() right after
// a run(). If the old instance saves a new state before the exchange, restore() is called again.
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

/// The number of run() calls in the trial of a new instance. If one of them fails, the executor puts the old
/// instance back.
inline constexpr std::uint64_t kTrialRuns = 10;

struct Swap {
  std::uint32_t index;  ///< the module's index on its device
  const channel::ModuleBlock& block;
  ThreadModule& before;                   ///< the running instance
  ThreadModule& next;                     ///< the new instance; attach() has been called, but not load()
  executor::Body& body;                   ///< the body through which the executor calls `next`
  ExecutorThreads& threads;               ///< the threads of the module's executor
  channel::SavedState& place;             ///< the memory in which the module saves its state
  channel::Activity& activity;            ///< the activity of the calling thread, which is not real-time
  std::string path;                       ///< the file of `next`
  const os::Fd& component;                ///< the content of this file
  os::Library::Origin origin;             ///< whether its libraries are searched for beside the file
  irp::Property::Values properties;       ///< the current values of the module's properties
  std::function<Result<void>()> connect;  ///< connects the ports of `next` to its links
  std::function<std::unique_lock<std::mutex>()> exclude;  ///< no handler is called while the lock is held
  std::function<void(ThreadModule&)> handle_by;           ///< sets the instance whose handlers are called
  std::function<bool()> ends;  ///< true once the executors have halted or the node has abandoned the swap
};

struct Swapped {
  bool kept = false;
  std::string text;  ///< the first row of the new instance, or the reason why it was not kept
};

/// Carries out the swap, and waits for the exchange and the trial. If `next` is not kept, `before` continues
/// with the state that it saved itself.
Swapped carry_out(const Swap& swap);

}  // namespace takt::host
