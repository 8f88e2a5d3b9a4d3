// Which processors a device's threads run on.
#pragma once

#include <string>
#include <vector>

#include <takt/model/cell.hpp>

namespace takt::schedule {

struct Placement {
  std::vector<std::vector<int>> executors;  ///< of each executor; empty: any
  std::vector<int> background;        ///< of process modules, hooks and non-real-time modules; never empty
  std::vector<std::string> warnings;  ///< wishes that this machine cannot fulfil
};

/// Executors get the processor that the descriptor names, or one each from the highest down; everything else
/// gets those that are left, or all where none is left. Pure.
Placement place(const std::vector<model::Executor>& executors, const std::vector<int>& allowed);

/// Of the threads that serve an executor of this priority: its sporadic thread modules, and its programs.
constexpr int sporadic_priority(int executor) { return executor - 1; }
constexpr int program_priority(int executor, model::Operation operation) {
  const int priority = executor - (operation == model::Operation::periodic ? 2 : 3);
  return priority < 1 ? 1 : priority;
}

/// How many programs that wait for releases share one of the processors that they run on, at least 1: each
/// may spin for as many times less.
int programs_on_one(const model::Device& device, const Placement& placement);

}  // namespace takt::schedule
