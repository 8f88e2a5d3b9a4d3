// The simulation behind conveyor: a belt with parts and a light barrier at its end. SI units. For real-time
// threads.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace conveyor {

/// A part on the belt. The part with a given number is the same in every run.
struct Laid {
  std::uint32_t number = 0;  ///< from 1, in order of arrival at the barrier
  double x = 0;              ///< m, distance from the light barrier against the belt's direction
  double y = 0;              ///< m across the belt from its middle, within 5 cm
  double angle = 0;          ///< rad, from the belt to its longer side, within an eighth of a turn
  const char* kind = "";     ///< "bottle" for odd numbers, "box" for even ones
};

/// A belt whose parts lie `spacing` apart. A part that arrives at the barrier stops the belt until it is
/// taken away.
struct Belt {
  double acceleration = 1;  ///< m/s^2
  double spacing = 0.3;     ///< m

  double speed = 0;         ///< m/s
  double position = 0;      ///< m
  std::uint32_t parts = 0;  ///< number of parts that have arrived at the barrier
  bool holding = false;

  /// Moves the belt by one step. True if a part has just arrived at the barrier. A speed that is below 0 or
  /// not finite stops the belt.
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
  /// Tells the belt that the part `number` was taken away. The belt ignores the number of a part that is
  /// already gone.
  void taken(std::uint32_t number) noexcept {
    if (number == parts) holding = false;
  }
  /// The next part gets the number after `number`; its position does not change. Do not call it while a part
  /// is held.
  void recount(std::uint32_t number) noexcept {
    position -= spacing * (static_cast<double>(parts) - number);
    parts = number;
  }

  /// The number of the part at the barrier, or of the next one.
  [[nodiscard]] std::uint32_t first() const noexcept { return holding ? parts : parts + 1; }
  /// The part `number`, which must still be on the belt: first() or later.
  [[nodiscard]] Laid laid(std::uint32_t number) const noexcept {
    return {.number = number,
            .x = spacing * number - position,
            .y = 0.05 * std::sin(2.399963 * number),
            .angle = std::numbers::pi / 4 * std::sin(1.324718 * number),
            .kind = number % 2 == 0 ? "box" : "bottle"};
  }
};

/// The time in s from the removal of a part to the arrival of the next one: from rest over `spacing`, at most
/// at `speed`. With the time `held` for which a part is held, 60 / (time_between + held) parts arrive per
/// minute.
inline double time_between(double spacing, double speed, double acceleration) noexcept {
  if (speed * speed >= 2 * acceleration * spacing) return std::sqrt(2 * spacing / acceleration);
  return spacing / speed + speed / (2 * acceleration);
}

}  // namespace conveyor
