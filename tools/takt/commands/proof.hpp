// Whether every deadline of a cell is kept, as `takt check` says it.
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

/// Fails where there is no such file, or it is no profile, with every mistake at its line.
Result<model::Profile> read_profile(const std::string& file);

/// With what to reckon.
struct ProofOptions {
  std::string profile;            ///< the file of a profile; empty: the modules' budgets
  double factor = 1;              ///< the longest run is this much longer than measured or stated; 1 to 1000
  std::optional<int> processors;  ///< of each device, at least 1; none: as many as this program may use

  [[nodiscard]] bool given() const { return !profile.empty() || factor != 1 || processors; }
};

struct Proof {
  bool of_profile = false;  ///< else of the budgets
  double factor = 1;
  std::size_t processors = 1;
  std::vector<std::vector<schedule::WorstCase>> devices;  ///< in the cell's order
  Problems missed;                                        ///< one for each deadline that is not kept
  Problems warnings;  ///< wishes of the descriptor that a device of so many processors cannot fulfil
};

/// Fails when the profile cannot be read, or a run time is neither in it nor stated. Reads a file.
Result<Proof> prove(const model::Cell& cell, const std::vector<schedule::DevicePlan>& plans,
                    const ProofOptions& options);

}  // namespace takt::tool
