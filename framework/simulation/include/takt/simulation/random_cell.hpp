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

/// Makes one to three devices with a few modules each, their connections and some faults; the same seed gives
/// the same cell. model::validate() and schedule::plan() accept it. Allocates.
RandomCell random_cell(std::uint64_t seed);

}  // namespace takt::simulation
