// The simulation of the component conveyor: a belt with parts and a light barrier at its end. SI units.
// Real-time threads may use everything here.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

namespace conveyor {

/// A part on the belt. A part with the same number has the same properties in every run.
struct Laid {
  std::uint32_t number = 0;  ///< number in the order of arrival at the barrier; the first part is 1
  double x = 0;              ///< m, distance that the part has to travel to the light barrier
  double y = 0;              ///< m across the belt from its centre line, at most 5 cm
  double angle = 0;       ///< rad, from the belt's direction to the longer side, at most an eighth of a turn
  const char* kind = "";  ///< "bottle" for odd numbers, "box" for even ones
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

  /// Moves the belt by one step. Returns true if a part has just arrived at the barrier. A speed that is
  /// below 0 or not finite stops the belt.
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
  /// Removes the part `number` from the barrier. The belt ignores the number of a part that is already gone.
  void taken(std::uint32_t number) noexcept {
    if (number == parts) holding = false;
  }
  /// Sets the count of parts, so that the next part gets the number after `number`. The next part keeps its
  /// position. Do not call this while the belt holds a part.
  void recount(std::uint32_t number) noexcept {
    position -= spacing * (static_cast<double>(parts) - number);
    parts = number;
  }

  /// Returns the number of the part at the barrier, or of the next part if there is none.
  [[nodiscard]] std::uint32_t first() const noexcept { return holding ? parts : parts + 1; }
  /// Returns the part `number`, which must still be on the belt: first() or later.
  [[nodiscard]] Laid laid(std::uint32_t number) const noexcept {
    return {.number = number,
            .x = spacing * number - position,
            .y = 0.05 * std::sin(2.399963 * number),
            .angle = std::numbers::pi / 4 * std::sin(1.324718 * number),
            .kind = number % 2 == 0 ? "box" : "bottle"};
  }
};

/// Returns the time in s from the removal of a part to the arrival of the next part. The belt starts from
/// rest, moves by `spacing`, and does not exceed `speed`. If each part waits for the time `held`, 60 /
/// (time_between + held) parts arrive per minute.
inline double time_between(double spacing, double speed, double acceleration) noexcept {
  if (speed * speed >= 2 * acceleration * spacing) return std::sqrt(2 * spacing / acceleration);
  return spacing / speed + speed / (2 * acceleration);
}

}  // namespace conveyor
