// A value that follows another no faster than it may. For real-time threads.
#pragma once

#include <algorithm>
#include <cmath>

namespace rate_limiter {

struct Limits {
  double up = 1;    ///< units/s, at least 0
  double down = 1;  ///< units/s, at least 0
  double jerk = 0;  ///< units/s^2, how fast the rate itself may change; 0: as fast as it likes
};

/// With a limit on the change of rate it brakes in time: it comes to a value that stands still as fast as the
/// limits allow, and not beyond it. When the value turns round in front of it, the limit on the change of
/// rate goes first.
class SlewLimiter {
 public:
  void jump(double value) noexcept {
    value_ = value;
    rate_ = 0;
  }
  /// `dt` s after the last step, above 0.
  double step(double wanted, const Limits& limits, double dt) noexcept {
    const double error = wanted - value_;
    if (limits.jerk <= 0) {
      const double change = std::clamp(error, -limits.down * dt, limits.up * dt);
      // A rounding that is left is not worth a step of its own.
      const bool there = std::abs(error - change) <= 1e-12 * std::abs(change);
      value_ = there ? wanted : value_ + change;
      rate_ = change / dt;
      return value_;
    }
    const double braking = braking_rate(error, limits.jerk, dt);
    const double change = limits.jerk * dt;
    const double next =
        std::clamp(std::clamp(braking, -limits.down, limits.up), rate_ - change, rate_ + change);
    const bool there = next == braking && std::abs(error) <= change * dt;  // in this one step
    value_ = there ? wanted : value_ + next * dt;
    rate_ = next;
    return value_;
  }
  [[nodiscard]] double value() const noexcept { return value_; }
  [[nodiscard]] double rate() const noexcept { return rate_; }

 private:
  /// The rate from which, one jerk * dt less at each step, the value comes to rest exactly after `error`:
  /// with error = (n + 1)(n / 2 + part) of jerk * dt^2 it is (n + part) of jerk * dt.
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
