// A belt with parts on it and a light barrier at its end: what conveyor simulates. SI units. For real-time
// threads.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace conveyor {

/// A part that was laid on the belt; the same for a number in every run.
struct Laid {
  std::uint32_t number = 0;  ///< from 1, in the order in which they come to the barrier
  double x = 0;              ///< m along the belt, from the light barrier against the way that the belt runs
  double y = 0;              ///< m across the belt, from its middle: within 5 cm
  double angle = 0;          ///< rad, of its longer side to the belt: within an eighth of a turn
  const char* kind = "";     ///< "bottle" for odd numbers, "box" for even ones
};

/// Parts lie `spacing` apart. One that comes to the barrier is held there, and the belt with it, until it is
/// taken away.
struct Belt {
  double acceleration = 1;  ///< m/s^2
  double spacing = 0.3;     ///< m

  double speed = 0;         ///< m/s
  double position = 0;      ///< m
  std::uint32_t parts = 0;  ///< that have come to the barrier
  bool holding = false;

  /// True when a part has just come to the barrier. A wanted speed below 0, or that is no number, stops.
  bool step(double wanted_speed, double dt) noexcept {
    const double wanted = std::isfinite(wanted_speed) ? std::max(wanted_speed, 0.0) : 0.0;
    const double target = holding ? 0 : wanted;
    const double change = std::clamp(target - speed, -acceleration * dt, acceleration * dt);
    speed = holding ? 0 : speed + change;
    position += speed * dt;
    if (holding || position < spacing * (parts + 1.0)) return false;
    ++parts;
    holding = true;
    speed = 0;
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

  /// The part that is at the barrier or comes next.
  [[nodiscard]] std::uint32_t first() const noexcept { return holding ? parts : parts + 1; }
  /// Of a part that still lies on the belt: first() or later.
  [[nodiscard]] Laid laid(std::uint32_t number) const noexcept {
    return {.number = number,
            .x = spacing * number - position,
            .y = 0.05 * std::sin(2.399963 * number),
            .angle = std::numbers::pi / 4 * std::sin(1.324718 * number),
            .kind = number % 2 == 0 ? "box" : "bottle"};
  }
};

/// From a part's being taken to the next one's coming to the barrier, in s: from rest over `spacing`, at no
/// more than `speed`. With the time for which a part is held, it gives the parts that come in a minute: 60 /
/// (time_between + held).
inline double time_between(double spacing, double speed, double acceleration) noexcept {
  if (speed * speed >= 2 * acceleration * spacing) return std::sqrt(2 * spacing / acceleration);
  return spacing / speed + speed / (2 * acceleration);
}

}  // namespace conveyor
