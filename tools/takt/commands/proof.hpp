// Proves, for `takt check`, whether a cell keeps every deadline.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/schedule/analysis.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::tool {

/// Reads a profile from a file. Fails if the file does not exist or is not a valid profile; each problem
/// names its line.
Result<model::Profile> read_profile(const std::string& file);

/// The assumptions of a proof, from the command line.
struct ProofOptions {
  std::string profile;  ///< the file of the profile; if empty, the run times are the modules' budgets
  double factor = 1;    ///< multiplies the run times or budgets; from 1 to 1000
  std::optional<int>
      cpus;  ///< the number of CPUs of each device, at least 1; by default as many as this program may use

  [[nodiscard]] bool given() const { return !profile.empty() || factor != 1 || cpus; }
};

struct Proof {
  bool of_profile = false;  ///< the run times are from a profile, not from the budgets
  double factor = 1;
  std::size_t cpus = 1;                                   ///< the number of CPUs of each device
  std::vector<std::vector<schedule::WorstCase>> devices;  ///< one for each device, in the order of the cell
  Problems missed;                                        ///< one problem for each deadline that is not kept
  Problems warnings;  ///< settings in the descriptor that have no effect on a device with `cpus` CPUs
};

/// Reads the profile and proves the deadlines. Fails if the profile cannot be read, or if a module has
/// neither a run time in the profile nor a budget.
Result<Proof> prove(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                    const ProofOptions& options);

}  // namespace takt::tool
