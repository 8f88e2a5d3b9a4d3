// The longest run of each module, for the proof of deadlines.
#pragma once

#include <optional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/profile.hpp>

namespace takt::schedule {

/// The longest run of each module, indexed by device and module. Non-real modules have an empty entry,
/// because they have no deadline.
using LongestRuns = std::vector<std::vector<std::optional<Nanoseconds>>>;

/// Returns the longest run of each module. This is the maximum in the profile or, without a profile or if the
/// module did not run while the profile was recorded, the module's budget. Multiplies each time by `factor`,
/// which must be at least 1, and rounds it up. Fails if the profile belongs to another cell. Also fails, with
/// one problem per module, if a periodic or sporadic module has neither a run time nor a budget. Ignores
/// modules that occur only in the profile.
Result<LongestRuns> longest_runs(const model::Cell& cell, const model::Profile* profile, double factor);

/// Returns true if the cell has a periodic or sporadic module, and each of them has a budget.
bool all_state_budgets(const model::Cell& cell);

}  // namespace takt::schedule
