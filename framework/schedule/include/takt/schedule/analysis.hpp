// Proves, before a cell runs, that every module of a device meets its deadline. For each module that an
// executor, a sporadic thread or a program of the device runs, computes the longest time from a release to
// the end of the run. The computation takes CPUs and priorities into account.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/longest_runs.hpp>
#include <takt/schedule/placement.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::schedule {

/// The worst-case timing of a periodic or sporadic module.
struct WorstCase {
  std::uint32_t module = 0;  ///< index into model::Device::modules
  std::vector<int> cpus;     ///< the CPUs on which it may run
  Nanoseconds run{};         ///< the module's longest run
  Nanoseconds deadline{};    ///< time from the release; for a periodic module, its period
  /// The maximum time from a release to the end of the run. None if there is no bound; then `why` gives the
  /// reason.
  std::optional<Nanoseconds> response;
  std::string why;  ///< why the deadline may be missed, if not because of a long `response`; otherwise empty

  [[nodiscard]] bool kept() const { return why.empty() && response && *response <= deadline; }
};

/// Returns the worst case of each periodic and sporadic module, in the order of the descriptor.
///
/// `runs` contains the longest run of each module of the device; only non-real modules may have none. If all
/// deadlines are met, each `response` is an upper bound, provided that no run takes longer than `runs`
/// states. If a deadline may be missed, the responses of modules that depend on it are not reliable bounds.
/// The time that the machine and the scheduler need (wake-ups, condition(), transferring samples) is not
/// included. Allocates memory. The time that this takes is proportional to the number of table entries, and
/// longer if executors share a CPU.
std::vector<WorstCase> worst_cases(const model::Device& device, const DevicePlan& plan,
                                   const Placement& placement,
                                   const std::vector<std::optional<Nanoseconds>>& runs);

/// Returns one problem for each deadline that may be missed, at the line of the module.
Problems missed_deadlines(const model::Cell& cell, const model::Device& device,
                          const std::vector<WorstCase>& worst_cases);

}  // namespace takt::schedule
