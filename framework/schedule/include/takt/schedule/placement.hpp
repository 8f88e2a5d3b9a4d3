// Chooses the CPUs of a device's threads.
#pragma once

#include <string>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/model/cpus.hpp>

namespace takt::schedule {

struct Placement {
  std::vector<std::vector<int>> executors;  ///< the CPUs of each executor; empty: any CPU
  std::vector<int> background;  ///< the CPUs of process modules, hooks and non-real modules; never empty
  std::vector<std::string> warnings;  ///< requests of the descriptor that cannot be met on this machine
};

/// Returns one sentence for each executor whose CPU in the descriptor is not permitted. Pure function.
std::vector<std::string> missing_cpus(const model::Device& device, const model::Cpus& cpus);

/// Chooses the CPUs. Each executor gets the CPU that the descriptor names for it, if this CPU is permitted.
/// Each executor without such a CPU gets one of the remaining ordinary CPUs, highest number first. All other
/// threads get the ordinary CPUs that are then left, or all ordinary CPUs if none is left. `cpus.ordinary`
/// must not be empty. Pure function.
Placement place(const model::Device& device, const model::Cpus& cpus);

/// The number of periodic and sporadic process modules per background CPU, rounded up; at least 1. The time
/// for which each of these modules may spin is divided by this number.
int programs_on_one(const model::Device& device, const Placement& placement);

}  // namespace takt::schedule
