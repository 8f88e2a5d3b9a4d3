// Chooses the CPUs and priorities of a device's threads.
#pragma once

#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::schedule {

struct Placement {
  std::vector<std::vector<int>> executors;  ///< the CPUs of each executor; empty: any CPU
  std::vector<int> background;  ///< the CPUs of process modules, hooks and non-real modules; never empty
  std::vector<std::string> warnings;  ///< requests of the descriptor that cannot be met on this machine
};

/// Each executor gets the CPU that the descriptor names. Executors without such a CPU get one of the
/// remaining CPUs each, highest number first. All other threads get the CPUs that are then left, or all CPUs
/// if none is left. `allowed` must not be empty. Pure function.
Placement place(const std::vector<model::Executor>& executors, const std::vector<int>& allowed);

/// The priorities of the other threads of an executor with the given priority: the thread that runs its
/// sporadic thread modules, and its programs.
constexpr int sporadic_priority(int executor) { return executor - 1; }
constexpr int program_priority(int executor, model::Operation operation) {
  const int priority = executor - (operation == model::Operation::periodic ? 2 : 3);
  return priority < 1 ? 1 : priority;
}

/// The number of programs that executors release, per background CPU; rounded up, at least 1. Each program
/// spins only for its spinning time divided by this number.
int programs_on_one(const model::Device& device, const Placement& placement);

}  // namespace takt::schedule
