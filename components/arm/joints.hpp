// Six driven joints with inertia and friction, each for itself: what arm simulates. SI units. For real-time
// threads.
#pragma once

#include <array>
#include <cstddef>

namespace arm {

inline constexpr std::size_t kAxes = 6;
using Joints = std::array<double, kAxes>;

struct JointModel {
  Joints inertia{12, 12, 8, 4, 4, 4};  ///< kg m^2
  double friction = 20;                ///< N m s/rad

  Joints position{0, -1.2, 1.6, 0, 1.1, 0};  ///< rad; at home
  Joints velocity{};                         ///< rad/s

  /// Velocity first, then the position with the new velocity. Friction implicitly, so that it never turns a
  /// joint round.
  void step(const Joints& torque, double dt) noexcept {
    for (std::size_t i = 0; i < kAxes; ++i) {
      velocity[i] = (velocity[i] + torque[i] / inertia[i] * dt) / (1 + friction / inertia[i] * dt);
      position[i] += velocity[i] * dt;
    }
  }
};

}  // namespace arm
