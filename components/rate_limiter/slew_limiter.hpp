// The mathematics of the component rate_limiter: limits the rate and the jerk of a value. Real-time threads
// may use everything here.
#pragma once

#include <algorithm>
#include <cmath>

namespace rate_limiter {

struct Limits {
  double up = 1;    ///< units/s, maximum rise, at least 0
  double down = 1;  ///< units/s, maximum fall, at least 0
  double jerk = 0;  ///< units/s^2, maximum change of the rate; 0: unlimited
};

/// Moves a value towards a target within the limits. With a jerk limit, the value reaches a constant target
/// as fast as the limits allow and does not overshoot. If the target reverses shortly before the value
/// reaches it, the jerk limit has precedence and the value overshoots.
class SlewLimiter {
 public:
  void jump(double value) noexcept {
    value_ = value;
    rate_ = 0;
  }
  /// Returns the limited value. `dt` is the time since the last step in s, above 0.
  double step(double wanted, const Limits& limits, double dt) noexcept {
    const double error = wanted - value_;
    if (limits.jerk <= 0) {
      const double change = std::clamp(error, -limits.down * dt, limits.up * dt);
      // Compare with a tolerance, so that a rounding error does not cost one more step.
      const bool there = std::abs(error - change) <= 1e-12 * std::abs(change);
      value_ = there ? wanted : value_ + change;
      rate_ = change / dt;
      return value_;
    }
    const double braking = braking_rate(error, limits.jerk, dt);
    const double change = limits.jerk * dt;
    const double next =
        std::clamp(std::clamp(braking, -limits.down, limits.up), rate_ - change, rate_ + change);
    const bool there = next == braking && std::abs(error) <= change * dt;  // reaches the target now
    value_ = there ? wanted : value_ + next * dt;
    rate_ = next;
    return value_;
  }
  [[nodiscard]] double value() const noexcept { return value_; }
  [[nodiscard]] double rate() const noexcept { return rate_; }

 private:
  /// Returns the rate at which the value must move now to stop exactly at the distance `error`, if the rate
  /// falls by jerk * dt per step. For error = (n + 1)(n / 2 + part) * jerk * dt^2, the rate is
  /// (n + part) * jerk * dt.
  static double braking_rate(double error, double jerk, double dt) noexcept {
    const double steps = std::abs(error) / (jerk * dt * dt);
    const double n = std::floor((std::sqrt(1 + 8 * steps) - 1) / 2);
    const double part = steps / (n + 1) - n / 2;
    return std::copysign((n + part) * jerk * dt, error);
  }

  double value_ = 0;
  double rate_ = 0;
};

}  // namespace rate_limiter
