// Proves, before a cell runs, that every module of a device meets its deadline. For each periodic or sporadic
// module, the analysis computes the longest time from a release to the end of the run. The computation takes
// CPUs and priorities into account.
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
  std::vector<int> cpus;     ///< the CPUs on which the module may run
  Nanoseconds run{};         ///< the module's longest run
  Nanoseconds deadline{};    ///< the time allowed from the release to the end of the run; for a periodic
                             ///< module, its period
  /// The maximum time from a release to the end of the run. Empty if no maximum could be found; then `why`
  /// gives the reason.
  std::optional<Nanoseconds> response;
  std::string why;  ///< the reason if the deadline may be missed for a cause other than a long `response`;
                    ///< otherwise empty

  [[nodiscard]] bool kept() const { return why.empty() && response && *response <= deadline; }
  /// True if the analysis finds no bound because it lacks information. Then the deadline may be kept or
  /// missed.
  [[nodiscard]] bool unknown() const;
};

/// Returns the worst case of each periodic and sporadic module, in the order of the descriptor.
///
/// `runs` contains the longest run of each module of the device; only non-real modules may have none. If all
/// deadlines are met, each `response` is an upper bound, provided that no run takes longer than `runs`
/// states. If a module may miss its deadline, the `response` of each module that this module can delay is not
/// a reliable bound. The results do not include the time that the machine and the scheduler need (wake-ups,
/// condition(), transferring samples). Allocates memory. The running time of this function is proportional to
/// the number of table entries, and longer if executors share a CPU.
std::vector<WorstCase> worst_cases(const model::Device& device, const DevicePlan& plan,
                                   const Placement& placement,
                                   const std::vector<std::optional<Nanoseconds>>& runs);

/// Returns one problem for each deadline that may be missed. The problem refers to the line of the module.
Problems missed_deadlines(const model::Cell& cell, const model::Device& device,
                          const std::vector<WorstCase>& worst_cases);

}  // namespace takt::schedule
