// The duration of a simulated run().
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/profile.hpp>
#include <takt/simulation/draws.hpp>

namespace takt::simulation {

/// The run time of one module. Uses the measured times of the profile. Without them, draws a time between a
/// third and nine tenths of the module's budget. Without a budget, uses a few percent of the period or
/// deadline, at most about a millisecond.
class RunTime {
 public:
  RunTime(const model::Cell& cell, const model::Device& device, const model::Module& module,
          const model::Profile& profile);
  Nanoseconds draw(Draws& draws) const;

 private:
  model::RunTimes times_;
};

}  // namespace takt::simulation
