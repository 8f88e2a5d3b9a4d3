// The parameters of a six-axis arm: geometry, limits, masses. SI units, angles in rad. Do not use this header
// in real-time threads, because it reads files.
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
  double theta = 0;                 ///< rad, turn about z when the axis is at position 0
  double lower = -3;                ///< rad
  double upper = 3;                 ///< rad
  double velocity = 1;              ///< rad/s, maximum for set points
  double acceleration = 1;          ///< rad/s^2, maximum for set points
  double torque = 100;              ///< N m, maximum torque of the drive
  double home = 0;                  ///< rad, position of the axis while the arm waits for a request
  double mass = 1;                  ///< kg
  std::array<double, 3> centre{};   ///< m, centre of mass
  std::array<double, 3> inertia{};  ///< kg m^2, about the centre of mass
  double rotor = 1;                 ///< kg m^2, inertia of motor and gear as seen from the axis; above 0
  double viscous = 0;               ///< N m s/rad, viscous friction
  double dry = 0;                   ///< N m, dry friction
};

using Parameters = std::array<Axis, kAxes>;

/// Returns the position at which the arm waits for a request.
inline Joints home(const Parameters& parameters) noexcept {
  Joints joints{};
  for (std::size_t i = 0; i < kAxes; ++i) joints[i] = parameters[i].home;
  return joints;
}

/// Returns the built-in arm. This arm is fictitious and has the proportions of an industrial arm with a
/// payload of 10 kg and a reach of 1.4 m. The tool, 0.15 m long, is part of the last link.
const Parameters& built_in();

/// Reads a JSON file as README.md describes it; an empty name gives the built-in arm. If this fails, returns
/// the error with its location: "arm.json: axes[2].mass: must be a number above 0".
std::variant<Parameters, std::string> read(const std::string& file);

}  // namespace arm_model
