// Finds the conditions of a machine that would spoil the run of a particular cell. These functions read
// nothing from the machine.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/trial.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::node {

/// The machine's conditions when a device is brought up.
struct Conditions {
  std::optional<os::Throttling> throttling{};
  bool prioritised = true;  ///< whether the system grants SCHED_FIFO
  bool memory_locked = true;
  std::uint64_t swap_bytes = 0;
  Nanoseconds timer_resolution{1};
  os::WakeUps wake_ups{};  ///< not measured if the count is 0
};

/// For each condition that spoils this run, returns a sentence that names the condition and its cure. Denied
/// priority and denied memory locking are not reported here, but by the threads that need them.
std::vector<std::string> warnings_for(const model::Device& device, const schedule::DevicePlan& plan,
                                      const Conditions& conditions);

/// Returns the command after which the kernel no longer interrupts threads that never sleep.
std::string throttling_cure(const os::Throttling& throttling);

/// Explains with a sentence and the cure why an executor got its CPU back only after `gap`, if `gap` is about
/// as long as the kernel's throttling lasts. Returns nothing for any other length, or if the kernel does not
/// throttle.
std::optional<std::string> throttled(const model::Executor& executor, Nanoseconds gap,
                                     const os::Throttling& throttling);

}  // namespace takt::node
