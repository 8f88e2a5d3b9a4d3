// The mathematics of the component servo: the position loop of an arm's joints, with the inverse dynamics of
// Orocos KDL. SI units, rad. The constructor allocates memory; real-time threads may call all other
// functions.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include "arm_model/kinematics.hpp"

namespace servo {

using arm_model::Joints;
using arm_model::kAxes;

/// Desired or measured motion of the axes.
struct Motion {
  Joints position{};
  Joints velocity{};
};

/// Controls the joints of an arm. The loop converts the error of each axis to a desired acceleration, as a
/// spring and a damper would. The model of the arm converts these accelerations to torques, so one bandwidth
/// suits every axis in every posture.
class JointServo {
 public:
  explicit JointServo(const arm_model::Parameters& parameters)
      : parameters_(parameters), chain_(arm_model::chain(parameters)) {}
  JointServo(const JointServo&) = delete;
  JointServo& operator=(const JointServo&) = delete;

  double bandwidth = 15;     ///< Hz
  double damping = 1;        ///< damping ratio; 1: no overshoot
  bool gravity = true;       ///< whether to feed forward the weight of the links
  bool acceleration = true;  ///< whether to feed forward the set points' acceleration, and the friction
  /// rad/s; below this speed, the servo feeds forward only a part of the dry friction.
  static constexpr double kDryBand = 0.05;

  /// Returns the torques in N m, within the limits of the drives. `last` is the set point from `dt` seconds
  /// ago. That set point caused the measured motion `is`, so the loop compares `is` with `last`.
  [[nodiscard]] Joints torque(const Motion& wanted, const Motion& last, const Motion& is,
                              double dt) noexcept {
    const double spring = std::pow(2 * std::numbers::pi * bandwidth, 2);
    const double damper = 2 * damping * 2 * std::numbers::pi * bandwidth;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const auto row = static_cast<unsigned>(i);
      const double most = 1.5 * parameters_[i].acceleration;  // limits the effect of a set point jump
      const double forward =
          acceleration ? std::clamp((wanted.velocity[i] - last.velocity[i]) / dt, -most, most) : 0;
      position_(row) = is.position[i];
      velocity_(row) = is.velocity[i];
      acceleration_(row) = forward + spring * (last.position[i] - is.position[i]) +
                           damper * (last.velocity[i] - is.velocity[i]);
    }
    solver_.CartToJnt(position_, velocity_, acceleration_, no_forces_, torque_);
    if (!gravity) {
      KDL::SetToZero(velocity_);
      KDL::SetToZero(acceleration_);
      solver_.CartToJnt(position_, velocity_, acceleration_, no_forces_, weight_);
    }
    Joints result{};
    for (std::size_t i = 0; i < kAxes; ++i) {
      const auto row = static_cast<unsigned>(i);
      const arm_model::Axis& axis = parameters_[i];
      const double speed = acceleration ? wanted.velocity[i] : 0;
      const double friction = axis.viscous * speed + axis.dry * std::tanh(speed / kDryBand);
      const double weight = gravity ? 0 : weight_(row);
      result[i] = std::clamp(torque_(row) - weight + friction, -axis.torque, axis.torque);
    }
    return result;
  }

 private:
  arm_model::Parameters parameters_;
  KDL::Chain chain_;
  KDL::ChainIdSolver_RNE solver_{chain_, KDL::Vector{0, 0, -9.81}};
  KDL::JntArray position_{kAxes};
  KDL::JntArray velocity_{kAxes};
  KDL::JntArray acceleration_{kAxes};
  KDL::JntArray torque_{kAxes};
  KDL::JntArray weight_{kAxes};
  KDL::Wrenches no_forces_ = KDL::Wrenches(kAxes, KDL::Wrench::Zero());
};

}  // namespace servo
