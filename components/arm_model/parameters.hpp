// What is known of an arm of six axes before it moves: its geometry, its limits, its masses. SI units, angles
// in rad. Not for real-time threads: reads files.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <variant>

namespace arm_model {

inline constexpr std::size_t kAxes = 6;
using Joints = std::array<double, kAxes>;

/// One axis and the link that it turns, in the notation of Denavit and Hartenberg: turn by theta + position
/// about z, go d along z, go a along the new x, turn by alpha about it. That is the link's frame, in which
/// its centre of mass and its inertia (about that centre, along the frame's axes) are given.
struct Axis {
  double a = 0;                     ///< m
  double alpha = 0;                 ///< rad
  double d = 0;                     ///< m
  double theta = 0;                 ///< rad, at position 0
  double lower = -3;                ///< rad
  double upper = 3;                 ///< rad
  double velocity = 1;              ///< rad/s, the most that is asked of it
  double acceleration = 1;          ///< rad/s^2, likewise
  double torque = 100;              ///< N m, the most that its drive gives
  double home = 0;                  ///< rad, where it waits
  double mass = 1;                  ///< kg
  std::array<double, 3> centre{};   ///< m
  std::array<double, 3> inertia{};  ///< kg m^2
  double rotor = 1;                 ///< kg m^2, of motor and gear as seen from the axis; above 0
  double viscous = 0;               ///< N m s/rad
  double dry = 0;                   ///< N m
};

using Parameters = std::array<Axis, kAxes>;

/// Where the arm waits.
inline Joints home(const Parameters& parameters) noexcept {
  Joints joints{};
  for (std::size_t i = 0; i < kAxes; ++i) joints[i] = parameters[i].home;
  return joints;
}

/// The arm that is built in: made up, with the proportions of an industrial arm for 10 kg that reaches 1.4 m.
/// The tool, 0.15 m long, is part of the last link.
const Parameters& built_in();

/// Of a file of JSON as README.md describes it; of an empty name, the one that is built in. If it does not
/// work out, what is wrong and where: "arm.json: axes[2].mass: must be a number above 0".
std::variant<Parameters, std::string> read(const std::string& file);

}  // namespace arm_model
