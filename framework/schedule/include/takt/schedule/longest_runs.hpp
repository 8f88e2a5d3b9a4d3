// The longest run of each module, as the proof of deadlines needs it.
#pragma once

#include <optional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/profile.hpp>

namespace takt::schedule {

/// Indexed by device and module. None for non-real-time modules, which have no deadline.
using LongestRuns = std::vector<std::vector<std::optional<Nanoseconds>>>;

/// The longest run in the profile, else the budget, multiplied by `factor` and rounded up. Without a profile,
/// only the budgets. factor >= 1. Fails with one problem for each periodic or sporadic module that has
/// neither, and if the profile is of another cell. Ignores modules that only the profile has.
Result<LongestRuns> longest_runs(const model::Cell& cell, const model::Profile* profile, double factor);

/// Whether every periodic and sporadic module has a budget.
bool all_state_budgets(const model::Cell& cell);

}  // namespace takt::schedule
