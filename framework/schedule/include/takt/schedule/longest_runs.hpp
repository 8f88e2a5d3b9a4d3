// How long one run of each module takes at most: what a proof that deadlines are kept reckons with.
#pragma once

#include <optional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/profile.hpp>

namespace takt::schedule {

/// By the index of the device and of its module. None for non-real-time modules, which have no deadline.
using LongestRuns = std::vector<std::vector<std::optional<Nanoseconds>>>;

/// The longest run that the profile saw, else the budget; times `factor`, rounded up. Without a profile the
/// budgets alone. factor >= 1. Fails with one problem for each periodic or sporadic module of which neither
/// is known, and when the profile is of another cell. Modules that only the profile has are nothing to it.
Result<LongestRuns> longest_runs(const model::Cell& cell, const model::Profile* profile, double factor);

/// Whether every periodic and sporadic module states its budget.
bool all_state_budgets(const model::Cell& cell);

}  // namespace takt::schedule
