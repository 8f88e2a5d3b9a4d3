// The SCHED_FIFO priorities ("levels") of an executor's threads and process modules. If P is the priority of
// the executor, the levels are, from the highest to the lowest:
//
//   P            the rows
//   P-1 ... P-5  the periodic process modules, by <priority>
//   P-6          the sporadic thread modules
//   P-7 ... P-9  the sporadic process modules, by <priority>
//
// So every periodic module of an executor has a higher level than its sporadic modules. A level that would be
// below 1 becomes level 1.
#pragma once

#include <cstdint>

#include <takt/model/cell.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::schedule {

inline constexpr int kPeriodicLevels = 5;
inline constexpr int kSporadicLevels = 3;

/// The level of the thread that runs the sporadic thread modules of an executor with this priority.
constexpr int sporadic_level(int executor) {
  const int level = executor - kPeriodicLevels - 1;
  return level < 1 ? 1 : level;
}

/// The level of a process module of this executor. `module` is the module's index on the device. Process
/// modules with equal <priority> have the same level. If there are more different priorities than levels,
/// neighbouring priorities share a level. The module must be in the plan.
int program_level(const model::Device& device, const ExecutorPlan& plan, std::uint32_t module);

}  // namespace takt::schedule
