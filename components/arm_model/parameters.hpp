// The parameters of a six-axis arm: geometry, limits, masses. SI units, angles in rad. Not for real-time
// threads, because it reads files.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <variant>

namespace arm_model {

inline constexpr std::size_t kAxes = 6;
using Joints = std::array<double, kAxes>;

/// One axis and the link that it turns, in Denavit-Hartenberg notation: turn by theta + position about z,
/// move d along z, move a along the new x, turn by alpha about the new x. The result is the link's frame. The
/// centre of mass and the inertia (about that centre, along the frame's axes) are given in this frame.
struct Axis {
  double a = 0;                     ///< m
  double alpha = 0;                 ///< rad
  double d = 0;                     ///< m
  double theta = 0;                 ///< rad, at position 0
  double lower = -3;                ///< rad
  double upper = 3;                 ///< rad
  double velocity = 1;              ///< rad/s, maximum of the set points
  double acceleration = 1;          ///< rad/s^2, likewise
  double torque = 100;              ///< N m, maximum of its drive
  double home = 0;                  ///< rad, waiting position
  double mass = 1;                  ///< kg
  std::array<double, 3> centre{};   ///< m
  std::array<double, 3> inertia{};  ///< kg m^2
  double rotor = 1;                 ///< kg m^2, inertia of motor and gear as seen from the axis; above 0
  double viscous = 0;               ///< N m s/rad
  double dry = 0;                   ///< N m
};

using Parameters = std::array<Axis, kAxes>;

/// The waiting position of the arm.
inline Joints home(const Parameters& parameters) noexcept {
  Joints joints{};
  for (std::size_t i = 0; i < kAxes; ++i) joints[i] = parameters[i].home;
  return joints;
}

/// The built-in arm: fictitious, with the proportions of an industrial arm with a payload of 10 kg and a
/// reach of 1.4 m. The tool, 0.15 m long, is part of the last link.
const Parameters& built_in();

/// Reads a JSON file as described in README.md; an empty name gives the built-in arm. On failure it returns
/// the error and its place: "arm.json: axes[2].mass: must be a number above 0".
std::variant<Parameters, std::string> read(const std::string& file);

}  // namespace arm_model
