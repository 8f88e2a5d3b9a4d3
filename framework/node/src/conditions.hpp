// Finds the conditions of a machine that would disturb a particular cell. These functions read nothing from
// the machine.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/trial.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::node {

/// The conditions of the machine when the node starts a device.
struct Conditions {
  std::optional<os::Throttling> throttling{};
  bool prioritised = true;  ///< true if the system grants SCHED_FIFO
  bool memory_locked = true;
  std::uint64_t swap_bytes = 0;
  Nanoseconds timer_resolution{1};
  os::WakeUps wake_ups{};  ///< delays with which the machine wakes threads; count is 0 if they were not
                           ///< measured
};

/// Returns a sentence for each condition that would disturb this device. The sentence names the condition and
/// its cure. Denied priorities and denied memory locking are not included, because the threads that need
/// these rights report them.
std::vector<std::string> warnings_for(const model::Device& device, const schedule::DevicePlan& plan,
                                      const Conditions& conditions);

/// Returns the command that stops the kernel from interrupting real-time threads that never sleep.
std::string throttling_cure(const os::Throttling& throttling);

/// Returns a sentence if the kernel's throttling explains why the executor had no CPU for the time `gap`. The
/// sentence states this and names the cure. Returns nothing if the kernel does not throttle, or if throttling
/// lasts much shorter or longer than `gap`.
std::optional<std::string> throttled(const model::Executor& executor, Nanoseconds gap,
                                     const os::Throttling& throttling);

}  // namespace takt::node
