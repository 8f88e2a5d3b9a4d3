// Proves whether a cell keeps every deadline, for `takt check`.
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

/// Fails if the file does not exist or is not a profile; each mistake is reported with its line.
Result<model::Profile> read_profile(const std::string& file);

/// The assumptions of a proof.
struct ProofOptions {
  std::string profile;      ///< the file of a profile; empty: use the modules' budgets
  double factor = 1;        ///< by which run times or budgets are multiplied; 1 to 1000
  std::optional<int> cpus;  ///< CPUs of each device, at least 1; none: as many as this program may use

  [[nodiscard]] bool given() const { return !profile.empty() || factor != 1 || cpus; }
};

struct Proof {
  bool of_profile = false;  ///< run times from a profile; else from the budgets
  double factor = 1;
  std::size_t cpus = 1;                                   ///< of each device
  std::vector<std::vector<schedule::WorstCase>> devices;  ///< in the cell's order
  Problems missed;                                        ///< one for each deadline that is not kept
  Problems warnings;  ///< requests of the descriptor that a device with so few CPUs cannot meet
};

/// Reads the profile and proves the deadlines. Fails if the profile cannot be read, or if a module has
/// neither a run time in the profile nor a budget.
Result<Proof> prove(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                    const ProofOptions& options);

}  // namespace takt::tool
