// What of a machine would spoil one run: the part of the diagnosis that depends on what the run wants. Pure.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/os/machine.hpp>
#include <takt/os/trial.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::node {

/// What is known when a device is brought up.
struct Conditions {
  std::optional<os::Throttling> throttling{};
  bool prioritised = true;  ///< SCHED_FIFO is granted
  bool memory_locked = true;
  std::uint64_t swap_bytes = 0;
  Nanoseconds timer_resolution{1};
  os::WakeUps wake_ups{};  ///< none: they were not tried
};

/// A sentence with the cure for each thing that spoils this run. Empty when nothing does. That the system
/// refuses priority or memory is said by who is refused.
std::vector<std::string> warnings_for(const model::Device& device, const schedule::DevicePlan& plan,
                                      const Conditions& conditions);

/// What to do so that the kernel does not interrupt threads that never sleep: a command.
std::string throttling_cure(const os::Throttling& throttling);

/// What it means that the processor came back to an executor only after `gap`, when that is about as long as
/// the kernel keeps a processor from real-time threads: a sentence with the cure. None for any other length,
/// and where the kernel keeps nothing.
std::optional<std::string> throttled(const model::Executor& executor, Nanoseconds gap,
                                     const os::Throttling& throttling);

}  // namespace takt::node
