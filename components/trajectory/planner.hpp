// Plans the legs of a cycle for a request, with a bounded amount of work in each period (see Search). The
// planner rejects an impossible request before the arm moves. SI units, rad. Only the constructor allocates
// memory.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "leg.hpp"

namespace trajectory {

/// A request to move one part, and the parameters of the motion.
struct Task {
  KDL::Frame pick;
  KDL::Frame place;
  double approach = 0.15;  ///< m, length of the straight lines above part and place, along the tool
  double grip = 0.3;       ///< s, time for the gripper to close and to open
  Limits limits;
};

/// The legs in order. If the gripper holds no part during `up`, `give_up` replaces the remaining legs.
enum class Step { to_pick, down, grip, up, to_place, lower, release, retreat, home, give_up };
inline constexpr std::size_t kSteps = 10;

struct Plan {
  Line pick;   // straight line from the part upwards
  Line place;  // straight line from the target place upwards
  std::array<Leg, kSteps> legs;

  [[nodiscard]] Leg& leg(Step step) noexcept { return legs[static_cast<std::size_t>(step)]; }
  [[nodiscard]] const Leg& leg(Step step) const noexcept { return legs[static_cast<std::size_t>(step)]; }
  /// Returns the total duration in s of the legs up to and including `last`.
  [[nodiscard]] double until(Step last) const noexcept {
    double sum = 0;
    for (std::size_t i = 0; i <= static_cast<std::size_t>(last); ++i) sum += legs[i].duration;
    return sum;
  }
};

class Planner {
 public:
  static constexpr int kSearchSteps = 6;  ///< maximum number of Search::step() calls per step()

  enum class State { idle, planning, planned, out_of_reach, joint_limit, singular };

  /// Creates a planner for this arm. Allocates memory.
  explicit Planner(const arm_model::Parameters& parameters) : kinematics_(parameters) {}

  /// Begins to plan a cycle that starts and ends at `rest`, and stores it in `plan`. Do not move `plan`: its
  /// legs contain pointers to its lines. The plan is complete when step() returns State::planned.
  void begin(const Task& task, const Joints& rest, Plan& plan) noexcept {
    task_ = task;
    rest_ = rest;
    plan_ = &plan;
    look_at(true);
    state_ = State::planning;
  }

  /// Continues the planning for at most 40 us. Returns the new state of the planner.
  State step() noexcept {
    if (state_ != State::planning) return state_;
    if (searching_)
      search();
    else
      draw();
    return state_;
  }

 private:
  void look_at(bool pick) noexcept {
    at_pick_ = pick;
    searching_ = true;
    saw_limit_ = saw_singular_ = false;
    search_.begin(pick ? task_.pick : task_.place, pick ? rest_ : plan_->leg(Step::to_pick).to);
  }

  void search() noexcept {
    for (int n = 0; n < kSearchSteps; ++n) {
      const arm_model::Reach reach = search_.step();
      if (reach == arm_model::Reach::searching) continue;
      if (reach == arm_model::Reach::found) {
        const KDL::Frame& pose = at_pick_ ? task_.pick : task_.place;
        line().begin(pose, pose.M.UnitZ() * -task_.approach, search_.found());
        searching_ = false;
        return;
      }
      state_ = saw_singular_                                          ? State::singular
               : saw_limit_ || reach == arm_model::Reach::joint_limit ? State::joint_limit
                                                                      : State::out_of_reach;
      return;
    }
  }

  void draw() noexcept {
    const Line::State drawn = line().step(kinematics_);
    if (drawn == Line::State::building) return;
    if (drawn == Line::State::done) {
      finish();
      return;
    }
    // Another configuration of the axes may still make this line possible.
    saw_limit_ |= drawn == Line::State::joint_limit;
    saw_singular_ |= drawn == Line::State::singular;
    search_.go_on();
    searching_ = true;
  }

  void finish() noexcept {
    const Limits& limits = task_.limits;
    const Joints at = line().at(0).position;
    const Joints above = line().at(1).position;
    const Leg up = Leg::along(line(), false, limits);
    Leg down = up;
    down.kind = Leg::Kind::line_back;  // moves along the line above the part, in reverse
    if (at_pick_) {
      plan_->leg(Step::to_pick) = Leg::turn(rest_, above, limits);
      plan_->leg(Step::down) = down;
      plan_->leg(Step::grip) = Leg::wait(at, task_.grip);
      plan_->leg(Step::up) = up;
      plan_->leg(Step::give_up) = Leg::turn(above, rest_, limits);
      look_at(false);
      return;
    }
    plan_->leg(Step::to_place) = Leg::turn(plan_->leg(Step::to_pick).to, above, limits);
    plan_->leg(Step::lower) = down;
    plan_->leg(Step::release) = Leg::wait(at, task_.grip);
    plan_->leg(Step::retreat) = up;
    plan_->leg(Step::home) = Leg::turn(above, rest_, limits);
    state_ = State::planned;
  }

  [[nodiscard]] Line& line() noexcept { return at_pick_ ? plan_->pick : plan_->place; }

  arm_model::Kinematics kinematics_;
  arm_model::Search search_{kinematics_};
  Task task_;
  Joints rest_{};
  Plan* plan_ = nullptr;
  State state_ = State::idle;
  bool at_pick_ = true;
  bool searching_ = true;
  bool saw_limit_ = false;
  bool saw_singular_ = false;
};

}  // namespace trajectory
