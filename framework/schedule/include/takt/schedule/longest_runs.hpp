// The longest run of each module, as the proof of deadlines needs it.
#pragma once

#include <optional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/profile.hpp>

namespace takt::schedule {

/// Indexed by device and module. An entry is empty for non-real-time modules, which have no deadline.
using LongestRuns = std::vector<std::vector<std::optional<Nanoseconds>>>;

/// Returns for each module the longest run in the profile, or the budget if there is no profile or the module
/// did not run in it. Multiplies each time by `factor`, which is at least 1, and rounds it up. Fails if the
/// profile belongs to another cell. Also fails with one problem for each periodic or sporadic module that has
/// neither a run time nor a budget. Ignores modules that occur only in the profile.
Result<LongestRuns> longest_runs(const model::Cell& cell, const model::Profile* profile, double factor);

/// Whether every periodic and sporadic module has a budget.
bool all_state_budgets(const model::Cell& cell);

}  // namespace takt::schedule
