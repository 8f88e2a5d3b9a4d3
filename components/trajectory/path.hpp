// Moves the set points along a plan, one period at a time. The motion can stop anywhere, and the set points
// stay on the path while they come to rest. SI units, rad. Nothing here allocates memory.
#pragma once

#include <algorithm>
#include <cmath>

#include "planner.hpp"

namespace trajectory {

/// The motion along a plan. Path time advances at a rate from 0 (held) to 1. The rate changes as fast as the
/// acceleration limits of all axes allow, on top of the accelerations that the path itself needs. So no set
/// point exceeds an axis limit.
class Path {
 public:
  /// Fractions of the axis limits: velocity of a plan, acceleration of a plan, and acceleration of a plan
  /// together with a stop on the path.
  static constexpr double kVelocityShare = 0.98;
  static constexpr double kPlanShare = 0.8;
  static constexpr double kHoldShare = 0.97;

  /// Returns the limits for plans of this arm. `speed` is a fraction; `tool` is the maximum tool speed on
  /// straight lines, in m/s.
  static Limits limits(const arm_model::Parameters& arm, double speed, double tool) noexcept {
    Limits limits{.tool = tool};
    for (std::size_t i = 0; i < kAxes; ++i) {
      limits.velocity[i] = kVelocityShare * arm[i].velocity * speed;
      limits.acceleration[i] = kPlanShare * arm[i].acceleration * speed * speed;
    }
    return limits;
  }
  /// Returns the acceleration limits for advance().
  static Joints most_acceleration(const arm_model::Parameters& arm) noexcept {
    Joints most{};
    for (std::size_t i = 0; i < kAxes; ++i) most[i] = kHoldShare * arm[i].acceleration;
    return most;
  }

  /// Creates a path at rest at this position.
  explicit Path(const Joints& rest = {}) noexcept : at_{rest, {}, {}} {}

  /// Starts the plan at the leg `first`. Do not change the plan while busy() is true.
  void begin(const Plan& plan, Step first) noexcept {
    plan_ = &plan;
    step_ = first;
    time_ = 0;
    busy_ = true;
  }
  [[nodiscard]] bool busy() const noexcept { return busy_; }
  /// The current leg; valid only while busy() is true.
  [[nodiscard]] Step step() const noexcept { return step_; }
  /// The leg that the last advance() ended, if any.
  struct Ended {
    bool any = false;
    Step step{};
  };
  [[nodiscard]] Ended ended() const noexcept { return ended_; }
  /// Makes the arm go home after the leg `up`. Call this during that leg.
  void give_up() noexcept { give_up_ = true; }
  [[nodiscard]] const Joints& position() const noexcept { return at_.position; }
  [[nodiscard]] const Joints& velocity() const noexcept { return velocity_; }

  void advance(bool enabled, const Joints& most_acceleration, double dt) noexcept {
    ended_ = {};
    const double before = rate_;
    rate_ = next_rate(enabled ? 1 : 0, most_acceleration, dt);
    if (!busy_) {
      velocity_ = {};
      return;
    }
    time_ += (before + rate_) / 2 * dt;
    if (time_ >= plan_->leg(step_).duration) end_leg();
    at_ = busy_ ? plan_->leg(step_).at(time_) : at_;
    for (std::size_t i = 0; i < kAxes; ++i) velocity_[i] = at_.slope[i] * rate_;
  }

 private:
  static constexpr double kFastest = 20;  // 1/s, maximum change of `rate_` per second

  [[nodiscard]] double next_rate(double wanted, const Joints& most, double dt) const noexcept {
    double lowest = -kFastest;
    double highest = kFastest;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const double slope = at_.slope[i];
      if (std::abs(slope) < 1e-9) continue;
      // Solves -most <= bend rate^2 + slope change <= most for the change of the rate.
      const double of_path = at_.bend[i] * rate_ * rate_;
      const double one = (-most[i] - of_path) / slope;
      const double other = (most[i] - of_path) / slope;
      lowest = std::max(lowest, std::min(one, other));
      highest = std::min(highest, std::max(one, other));
    }
    return rate_ + std::clamp((wanted - rate_) / dt, std::min(lowest, 0.0), std::max(highest, 0.0)) * dt;
  }

  void end_leg() noexcept {
    ended_ = {true, step_};
    time_ -= plan_->leg(step_).duration;
    if (step_ == Step::home || step_ == Step::give_up) {
      at_ = {plan_->leg(step_).to, {}, {}};
      busy_ = false;
    } else if (step_ == Step::up && give_up_) {
      step_ = Step::give_up;
    } else {
      step_ = static_cast<Step>(static_cast<int>(step_) + 1);
    }
    give_up_ = give_up_ && step_ == Step::up;
  }

  const Plan* plan_ = nullptr;
  Step step_{};
  double time_ = 0;  // s, since the beginning of the leg
  double rate_ = 1;
  Point at_;
  Joints velocity_{};
  Ended ended_;
  bool busy_ = false;
  bool give_up_ = false;
};

}  // namespace trajectory
