// Proves before anything runs that every module of a device meets its deadline. Computes the longest time
// from a release to the end of its run, for the executors, sporadic threads and programs of the device. Takes
// their CPUs and priorities into account.
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

/// The worst case of a periodic or sporadic module.
struct WorstCase {
  std::uint32_t module = 0;  ///< index in model::Device::modules
  std::vector<int> cpus;     ///< the CPUs on which it may run
  Nanoseconds run{};         ///< its longest run
  Nanoseconds deadline{};    ///< from its release; for a periodic module its period
  /// The maximum time from a release to the end of its run. None if there is no bound; then `why` has the
  /// reason.
  std::optional<Nanoseconds> response;
  std::string why;  ///< why the deadline is not kept, if a long response is not the cause; else empty

  [[nodiscard]] bool kept() const { return why.empty() && response && *response <= deadline; }
};

/// The worst case of each periodic and sporadic module, in the order of the descriptor. `runs` has the
/// longest run of each module of the device; only non-real-time modules may have none. If all deadlines are
/// kept, each `response` is an upper bound, provided that no run takes longer than in `runs`. If a deadline
/// is not kept, the other responses are bounds only as far as they do not depend on it. The time that the
/// machine and the scheduler need (wake-ups, condition(), moving samples) is not included. Allocates. Takes
/// time proportional to the entries of the tables, and longer if executors share a CPU.
std::vector<WorstCase> worst_cases(const model::Device& device, const DevicePlan& plan,
                                   const Placement& placement,
                                   const std::vector<std::optional<Nanoseconds>>& runs);

/// One problem for each deadline that is not kept, at the line of the module.
Problems missed_deadlines(const model::Cell& cell, const model::Device& device,
                          const std::vector<WorstCase>& worst_cases);

}  // namespace takt::schedule
