// A plan at once instead of a piece each period: for tests, and to know beforehand how long a cycle will
// take. Not for real-time threads. SI units, rad.
#pragma once

#include <memory>

#include "path.hpp"

namespace trajectory {

/// What trajectory asks for with its properties as they are by default.
inline Task usual_task(const arm_model::Parameters& arm, const KDL::Frame& pick, const KDL::Frame& place) {
  Task task;
  task.pick = pick;
  task.place = place;
  task.limits = Path::limits(arm, 1, 0.6);
  return task;
}

struct WholePlan {
  std::unique_ptr<Plan> plan = std::make_unique<Plan>();
  Planner::State state = Planner::State::planning;
  int periods = 0;  ///< that the planning takes
};

/// From home.
inline WholePlan whole_plan(const arm_model::Parameters& arm, const Task& task) {
  Planner planner{arm};
  WholePlan result;
  planner.begin(task, arm_model::home(arm), *result.plan);
  while (result.state == Planner::State::planning) {
    result.state = planner.step();
    ++result.periods;
  }
  return result;
}

}  // namespace trajectory
