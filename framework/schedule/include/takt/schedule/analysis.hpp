// Whether every module of a device is done by its deadline, before anything runs: the longest time from a
// release to its end, for the executors, sporadic threads and programs as they are placed and preempt each
// other.
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

/// Of a periodic or sporadic module.
struct WorstCase {
  std::uint32_t module = 0;  ///< index in model::Device::modules
  std::vector<int> cpus;     ///< on which it runs
  Nanoseconds run{};         ///< the longest
  Nanoseconds deadline{};    ///< from its release; of a periodic module its period
  /// From its release to its end, at most. None when there is no bound, and `why` says the reason.
  std::optional<Nanoseconds> response;
  std::string why;  ///< why the deadline is not kept although `response` is none or short; else empty

  [[nodiscard]] bool kept() const { return why.empty() && response && *response <= deadline; }
};

/// One for each periodic and sporadic module, in the order of the file. `runs` are those of the device, none
/// of them missing but of non-real-time modules. When all deadlines are kept, each `response` is an upper
/// bound as long as no run takes longer than stated; when one is not, the others are bounds only as far as
/// they do not depend on it. What the machine and the scheduler take themselves (wake-ups, condition(),
/// moving samples) is not in it. Allocates; takes time for the entries of the tables, longer where executors
/// share a processor.
std::vector<WorstCase> worst_cases(const model::Device& device, const DevicePlan& plan,
                                   const Placement& placement,
                                   const std::vector<std::optional<Nanoseconds>>& runs);

/// One for each deadline that is not kept, at the line of the module.
Problems missed_deadlines(const model::Cell& cell, const model::Device& device,
                          const std::vector<WorstCase>& worst_cases);

}  // namespace takt::schedule
