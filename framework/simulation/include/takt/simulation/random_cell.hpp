// Small cells by chance, with what goes wrong in them: many different ones are where a scheduler's mistakes
// are found.
#pragma once

#include <cstdint>

#include <takt/simulation/simulation.hpp>

namespace takt::simulation {

struct RandomCell {
  model::Cell cell;
  std::vector<schedule::DevicePlan> plans;
  Options options;  ///< with the seed
};

/// One to three devices of a few modules each, their connections, and some faults: always the same ones for
/// one seed. Valid as model::validate() and schedule::plan() say. Allocates.
RandomCell random_cell(std::uint64_t seed);

}  // namespace takt::simulation
