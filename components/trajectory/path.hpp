// The arm on its way through a plan: where the axes are to be, period by period. It can be held up anywhere
// and stays on the path while it comes to rest. SI units, rad. Nothing allocates.
#pragma once

#include <algorithm>
#include <cmath>

#include "planner.hpp"

namespace trajectory {

/// Time on the path runs at `rate`, from 0 (held) to 1. The rate changes as fast as the accelerations of all
/// axes allow together with those of the path, so that no axis is asked for more than its limit.
class Path {
 public:
  /// Of the limits of an axis: what plans are made with, and what is left beside for coming to rest.
  static constexpr double kVelocityShare = 0.98;
  static constexpr double kPlanShare = 0.8;
  static constexpr double kHoldShare = 0.97;

  /// Of plans for this arm, at `speed` (a share) and with the tool at `tool` m/s at most on straight lines.
  static Limits limits(const arm_model::Parameters& arm, double speed, double tool) noexcept {
    Limits limits{.tool = tool};
    for (std::size_t i = 0; i < kAxes; ++i) {
      limits.velocity[i] = kVelocityShare * arm[i].velocity * speed;
      limits.acceleration[i] = kPlanShare * arm[i].acceleration * speed * speed;
    }
    return limits;
  }
  /// For advance().
  static Joints most_acceleration(const arm_model::Parameters& arm) noexcept {
    Joints most{};
    for (std::size_t i = 0; i < kAxes; ++i) most[i] = kHoldShare * arm[i].acceleration;
    return most;
  }

  /// At rest there.
  explicit Path(const Joints& rest = {}) noexcept : at_{rest, {}, {}} {}

  /// Through the plan from its leg `first` on. The plan must stay as it is while busy().
  void begin(const Plan& plan, Step first) noexcept {
    plan_ = &plan;
    step_ = first;
    time_ = 0;
    busy_ = true;
  }
  [[nodiscard]] bool busy() const noexcept { return busy_; }
  /// The leg that it is on. While busy().
  [[nodiscard]] Step step() const noexcept { return step_; }
  /// The leg that the last advance() came to the end of; none: nothing.
  struct Ended {
    bool any = false;
    Step step{};
  };
  [[nodiscard]] Ended ended() const noexcept { return ended_; }
  /// In the leg `up`: the arm goes home from its end.
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
  static constexpr double kFastest = 20;  // 1/s, that the rate changes at most

  [[nodiscard]] double next_rate(double wanted, const Joints& most, double dt) const noexcept {
    double lowest = -kFastest;
    double highest = kFastest;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const double slope = at_.slope[i];
      if (std::abs(slope) < 1e-9) continue;
      // -most <= bend rate^2 + slope change <= most
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
  double time_ = 0;  // s, in the leg
  double rate_ = 1;
  Point at_;
  Joints velocity_{};
  Ended ended_;
  bool busy_ = false;
  bool give_up_ = false;
};

}  // namespace trajectory
