// A belt with parts on it and a light barrier at its end: what conveyor simulates. SI units. For real-time
// threads.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace conveyor {

/// Parts lie `spacing` apart. One that comes to the barrier is held there, and the belt with it, until it is
/// taken away.
struct Belt {
  double acceleration = 1;  ///< m/s^2
  double spacing = 0.3;     ///< m

  double speed = 0;         ///< m/s
  double position = 0;      ///< m
  std::uint32_t parts = 0;  ///< that have come to the barrier
  bool holding = false;

  /// True when a part has just come to the barrier.
  bool step(double wanted_speed, double dt) noexcept {
    const double target = holding ? 0 : wanted_speed;
    const double change = std::clamp(target - speed, -acceleration * dt, acceleration * dt);
    speed = holding ? 0 : speed + change;
    position += speed * dt;
    if (holding || position < spacing * (parts + 1.0)) return false;
    ++parts;
    holding = true;
    return true;
  }
  /// The part at the barrier was taken away. A number that is not its own is of a part that is gone already.
  void taken(std::uint32_t number) noexcept {
    if (number == parts) holding = false;
  }
  /// The next part gets the number after this one; where it lies does not change. Not while one is held.
  void recount(std::uint32_t number) noexcept {
    position -= spacing * (static_cast<double>(parts) - number);
    parts = number;
  }
  /// Where the part lies across the belt, from its middle: within 5 cm, different from part to part.
  [[nodiscard]] double offset() const noexcept { return 0.05 * std::sin(2.399963 * parts); }
};

}  // namespace conveyor
