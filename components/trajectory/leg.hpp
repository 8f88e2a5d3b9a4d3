// One move of the arm from rest to rest, as fast as its limits allow. SI units, rad. Nothing here allocates
// memory.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "line.hpp"

namespace trajectory {

/// A polynomial that rises from 0 to 1 for u from 0 to 1, with zero velocity and acceleration at both ends.
/// The two functions below are its first and second derivatives.
constexpr double quintic(double u) noexcept { return u * u * u * (10 + u * (-15 + 6 * u)); }
constexpr double quintic_slope(double u) noexcept { return 30 * u * u * (1 - u) * (1 - u); }
constexpr double quintic_bend(double u) noexcept { return 60 * u * (1 - u) * (1 - 2 * u); }

/// Limits of the set points.
struct Limits {
  Joints velocity{};      ///< rad/s
  Joints acceleration{};  ///< rad/s^2
  double tool = 1;        ///< m/s, tool speed on a straight line
};

struct Leg {
  enum class Kind { wait, turn, line, line_back };

  Kind kind = Kind::wait;
  Joints from{};               ///< where the arm waits or begins to turn
  Joints to{};                 ///< where the arm turns to; all axes arrive together
  const Line* line = nullptr;  ///< the path of the tool, for the kinds line and line_back
  double duration = 0;         ///< s

  static Leg wait(const Joints& at, double duration) noexcept {
    return {.from = at, .to = at, .duration = duration};
  }
  static Leg turn(const Joints& from, const Joints& to, const Limits& limits) noexcept {
    return Leg{.kind = Kind::turn, .from = from, .to = to}.fastest(limits, 0);
  }
  static Leg along(const Line& line, bool back, const Limits& limits) noexcept {
    return Leg{.kind = back ? Kind::line_back : Kind::line, .line = &line}.fastest(
        limits, 1.875 * line.length() / limits.tool);
  }

  /// Returns the set point at `time`, from 0 to `duration`.
  [[nodiscard]] Point at(double time) const noexcept {
    if (kind == Kind::wait) return {from, {}, {}};
    return by_share(std::clamp(time / duration, 0.0, 1.0), duration);
  }

 private:
  static constexpr std::size_t kSamples = 96;
  static constexpr double kShortest = 0.02;  // s

  [[nodiscard]] Point by_share(double u, double over) const noexcept {
    const double s = quintic(u);
    const double ds = quintic_slope(u) / over;
    const double dds = quintic_bend(u) / (over * over);
    Point point;
    if (kind == Kind::turn) {
      for (std::size_t i = 0; i < kAxes; ++i) {
        const double by = to[i] - from[i];
        point.position[i] = from[i] + by * s;
        point.slope[i] = by * ds;
        point.bend[i] = by * dds;
      }
      return point;
    }
    const double sign = kind == Kind::line ? 1 : -1;
    point = line->at(kind == Kind::line ? s : 1 - s);
    for (std::size_t i = 0; i < kAxes; ++i) {
      point.bend[i] = point.bend[i] * ds * ds + point.slope[i] * sign * dds;
      point.slope[i] *= sign * ds;
    }
    return point;
  }

  /// Returns this leg with the shortest duration that keeps the limits. Velocities are inversely proportional
  /// to the duration, accelerations to its square.
  [[nodiscard]] Leg fastest(const Limits& limits, double at_least) noexcept {
    duration = std::max(at_least, kShortest);
    for (std::size_t n = 0; n <= kSamples; ++n) {
      const Point point = by_share(static_cast<double>(n) / kSamples, 1);
      for (std::size_t i = 0; i < kAxes; ++i)
        duration = std::max({duration, std::abs(point.slope[i]) / limits.velocity[i],
                             std::sqrt(std::abs(point.bend[i]) / limits.acceleration[i])});
    }
    return *this;
  }
};

}  // namespace trajectory
