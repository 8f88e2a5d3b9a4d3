// Limits the rate and the jerk of a value. For real-time threads.
#pragma once

#include <algorithm>
#include <cmath>

namespace rate_limiter {

struct Limits {
  double up = 1;    ///< units/s, at least 0
  double down = 1;  ///< units/s, at least 0
  double jerk = 0;  ///< units/s^2, maximum change of the rate; 0: unlimited
};

/// With a jerk limit, the limiter brakes in time: it reaches a constant target as fast as the limits allow,
/// without overshoot. If the target reverses just ahead of the value, the jerk limit has precedence and the
/// value overshoots.
class SlewLimiter {
 public:
  void jump(double value) noexcept {
    value_ = value;
    rate_ = 0;
  }
  /// Returns the limited value. `dt` is the time in s since the last step, above 0.
  double step(double wanted, const Limits& limits, double dt) noexcept {
    const double error = wanted - value_;
    if (limits.jerk <= 0) {
      const double change = std::clamp(error, -limits.down * dt, limits.up * dt);
      // Do not spend another step on a rounding error.
      const bool there = std::abs(error - change) <= 1e-12 * std::abs(change);
      value_ = there ? wanted : value_ + change;
      rate_ = change / dt;
      return value_;
    }
    const double braking = braking_rate(error, limits.jerk, dt);
    const double change = limits.jerk * dt;
    const double next =
        std::clamp(std::clamp(braking, -limits.down, limits.up), rate_ - change, rate_ + change);
    const bool there = next == braking && std::abs(error) <= change * dt;  // reaches the target in this step
    value_ = there ? wanted : value_ + next * dt;
    rate_ = next;
    return value_;
  }
  [[nodiscard]] double value() const noexcept { return value_; }
  [[nodiscard]] double rate() const noexcept { return rate_; }

 private:
  /// The rate from which the value stops exactly at distance `error`, if the rate falls by jerk * dt per
  /// step. For error = (n + 1)(n / 2 + part) * jerk * dt^2 it is (n + part) * jerk * dt.
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
