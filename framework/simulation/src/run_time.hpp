// How long a simulated run() takes.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/profile.hpp>
#include <takt/simulation/draws.hpp>

namespace takt::simulation {

/// Of one module: as the profile measured it; else between a third and nine tenths of its budget; else some
/// percent of its period or deadline, at most a millisecond.
class RunTime {
 public:
  RunTime(const model::Cell& cell, const model::Device& device, const model::Module& module,
          const model::Profile& profile);
  Nanoseconds draw(Draws& draws) const;

 private:
  model::RunTimes times_;
};

}  // namespace takt::simulation
