// The position loop of an arm's joints: what servo computes every period. SI units. For real-time threads.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>

namespace servo {

inline constexpr std::size_t kAxes = 6;
using Joints = std::array<double, kAxes>;

/// Proportional to the error in position, damped by the error in velocity, bounded by what the drive can
/// give.
struct JointServo {
  double stiffness = 10000;  ///< N m/rad
  double damping = 600;      ///< N m s/rad
  double limit = 2000;       ///< N m

  [[nodiscard]] Joints torque(const Joints& wanted, const Joints& wanted_velocity, const Joints& is,
                              const Joints& velocity) const noexcept {
    Joints torque{};
    for (std::size_t i = 0; i < kAxes; ++i) {
      const double free = stiffness * (wanted[i] - is[i]) + damping * (wanted_velocity[i] - velocity[i]);
      torque[i] = std::clamp(free, -limit, limit);
    }
    return torque;
  }
};

}  // namespace servo
