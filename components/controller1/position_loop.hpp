// The mathematics of the component controller1: the position loop of a linear axis. Lengths are in mm, times
// in seconds. Real-time threads may use everything here.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace controller1 {

/// A move from standstill to standstill with limited velocity and acceleration. Its velocity profile is a
/// trapezoid, or a triangle if the move is too short to reach the velocity limit.
struct Move {
  double from = 0;
  double to = 0;
  double velocity = 1;      ///< mm/s, positive
  double acceleration = 1;  ///< mm/s^2, positive

  struct Point {
    double position;
    double velocity;
  };

  [[nodiscard]] double duration() const noexcept { return 2 * ramp() + cruise(); }

  /// Returns the set point `time` seconds after the move begins. Before the move, the set point is at the
  /// start of the move; after the move, it is at the end.
  [[nodiscard]] Point at(double time) const noexcept {
    const double sign = to < from ? -1.0 : 1.0;
    const double end = duration();
    if (time <= 0) return {from, 0};
    if (time >= end) return {to, 0};
    const double rising = std::min(time, ramp());
    const double level = std::clamp(time - ramp(), 0.0, cruise());
    const double falling = std::max(0.0, time - ramp() - cruise());
    const double top = acceleration * ramp();
    const double way = 0.5 * acceleration * rising * rising + top * level + top * falling -
                       0.5 * acceleration * falling * falling;
    return {from + sign * way, sign * acceleration * (rising - falling)};
  }

 private:
  [[nodiscard]] double ramp() const noexcept {
    return std::min(velocity / acceleration, std::sqrt(std::abs(to - from) / acceleration));
  }
  [[nodiscard]] double cruise() const noexcept {
    return std::max(0.0, std::abs(to - from) / (acceleration * ramp() + 1e-12) - ramp());
  }
};

/// Simulates the drive and the carriage. The drive follows a velocity command with a lag; the carriage
/// integrates the velocity.
struct Axis {
  double lag = 0.004;  ///< time constant of the drive's velocity loop
  double position = 0;
  double velocity = 0;

  void step(double command, double dt) noexcept {
    velocity += (command - velocity) * (1 - std::exp(-dt / lag));
    position += velocity * dt;
  }
};

/// A PI loop on the position error, with feed-forward of the profile's velocity and a limited command. While
/// the command is at its limit, the integral does not push it further beyond the limit.
struct PositionLoop {
  double gain = 60;             ///< 1/s
  double integral_gain = 800;   ///< 1/s^2
  double command_limit = 1000;  ///< mm/s
  double integral = 0;          ///< mm/s

  double step(Move::Point wanted, double position, double dt) noexcept {
    const double error = wanted.position - position;
    const double free = wanted.velocity + gain * error + integral;
    const double bounded = std::clamp(free, -command_limit, command_limit);
    if (free == bounded || (free > bounded) != (error > 0)) integral += integral_gain * error * dt;
    return bounded;
  }
};

/// Detects the end of a move: the error has been inside the window for `counter` consecutive periods. One
/// period would not suffice, because an overshoot may cross the window.
struct InPosition {
  double window = 0.01;      ///< mm
  std::int64_t counter = 5;  ///< number of periods, at least 1
  std::int64_t inside = 0;

  bool step(double error) noexcept {
    inside = std::abs(error) <= window ? inside + 1 : 0;
    return inside >= counter;
  }
};

/// Moves the axis back and forth between 0 and `stroke`, with a rest at each end.
struct Shuttle {
  double stroke = 100;
  double rest = 0.2;  ///< s, rest at each end after the axis is in position
  Move move{};
  Axis axis{};
  PositionLoop loop{};
  InPosition in_position{};

  double time = 0;           ///< s, since the move began
  double arrived = -1;       ///< s, the `time` at which the axis was in position; negative until then
  double largest_error = 0;  ///< mm, largest following error of all moves
  double settling = 0;       ///< s, longest time from the end of a profile until the axis is in position
  std::uint64_t moves = 0;

  void begin() noexcept {
    move.from = 0;
    move.to = stroke;
    time = 0;
    arrived = -1;
    axis.position = axis.velocity = loop.integral = 0;
    in_position.inside = 0;
  }

  void step(double dt) noexcept {
    time += dt;
    const Move::Point wanted = move.at(time);
    axis.step(loop.step(wanted, axis.position, dt), dt);
    const double error = wanted.position - axis.position;
    largest_error = std::max(largest_error, std::abs(error));
    if (time < move.duration()) return;
    const bool there = in_position.step(error);
    if (arrived < 0 && there) {
      arrived = time;
      settling = std::max(settling, time - move.duration());
      ++moves;
    }
    if (arrived >= 0 && time - arrived >= rest) {
      std::swap(move.from, move.to);
      time = 0;
      arrived = -1;
      in_position.inside = 0;
    }
  }
};

}  // namespace controller1
