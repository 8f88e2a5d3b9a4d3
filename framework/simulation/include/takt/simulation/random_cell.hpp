// Small random cells with random faults. Many different cells reveal the mistakes of a scheduler.
#pragma once

#include <cstdint>

#include <takt/simulation/simulation.hpp>

namespace takt::simulation {

struct RandomCell {
  model::Cell cell;
  std::vector<schedule::DevicePlan> plans;
  Options options;  ///< options for simulate(), with the seed
};

/// Makes a cell of one to three devices with a few modules each, their connections and some faults. The same
/// seed gives the same cell. model::validate() and schedule::plan() accept the cell. Allocates memory.
RandomCell random_cell(std::uint64_t seed);

}  // namespace takt::simulation
