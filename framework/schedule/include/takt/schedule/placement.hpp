// Chooses the CPUs and priorities of a device's threads.
#pragma once

#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::schedule {

struct Placement {
  std::vector<std::vector<int>> executors;  ///< the CPUs of each executor; empty: any
  std::vector<int> background;  ///< CPUs of process modules, hooks and non-real-time modules; never empty
  std::vector<std::string> warnings;  ///< requests of the descriptor that this machine cannot fulfil
};

/// Each executor gets the CPU that the descriptor names. The other executors get the remaining CPUs, highest
/// number first. All other threads get the CPUs that are left, or all CPUs if none is left. `allowed` must
/// not be empty. Pure.
Placement place(const std::vector<model::Executor>& executors, const std::vector<int>& allowed);

/// The priorities of the threads that belong to an executor of this priority: the thread of its sporadic
/// thread modules, and its programs.
constexpr int sporadic_priority(int executor) { return executor - 1; }
constexpr int program_priority(int executor, model::Operation operation) {
  const int priority = executor - (operation == model::Operation::periodic ? 2 : 3);
  return priority < 1 ? 1 : priority;
}

/// The number of released programs per background CPU, rounded up, at least 1. The spinning time of each
/// program is divided by this number.
int programs_on_one(const model::Device& device, const Placement& placement);

}  // namespace takt::schedule
