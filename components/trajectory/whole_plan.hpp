// Computes a whole plan in one call instead of a piece per period. Tests use this header, and so do programs
// that need the duration of a cycle in advance. Do not use it in real-time threads. SI units, rad.
#pragma once

#include <memory>

#include "path.hpp"

namespace trajectory {

/// Returns the task that the component trajectory has with its default properties.
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
  int periods = 0;  ///< number of periods that the planning takes
};

/// Plans a cycle that starts and ends at home.
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
