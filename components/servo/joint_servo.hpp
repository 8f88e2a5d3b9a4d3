// The position loop of an arm's joints: what servo computes every period, with the inverse dynamics of Orocos
// KDL. SI units, rad. The constructor allocates; the rest is for real-time threads.
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

/// What the axes are to do and what they do.
struct Motion {
  Joints position{};
  Joints velocity{};
};

/// The error of an axis asks for an acceleration, like a spring and a damper; the model of the arm says which
/// torques give all axes the accelerations that are wanted. So one bandwidth suits every axis in every
/// posture.
class JointServo {
 public:
  explicit JointServo(const arm_model::Parameters& parameters)
      : parameters_(parameters), chain_(arm_model::chain(parameters)) {}
  JointServo(const JointServo&) = delete;
  JointServo& operator=(const JointServo&) = delete;

  double bandwidth = 15;     ///< Hz
  double damping = 1;        ///< ratio; 1: no overshoot
  bool gravity = true;       ///< what the links weigh is carried without an error
  bool acceleration = true;  ///< that of the set points is fed forward, with the friction that goes with it
  static constexpr double kDryBand = 0.05;  ///< rad/s, within which dry friction is not fed forward in full

  /// N m, within what the drives give. `last` is the set point of `dt` ago: what is measured now is where
  /// that has led to, so it is compared with that.
  [[nodiscard]] Joints torque(const Motion& wanted, const Motion& last, const Motion& is,
                              double dt) noexcept {
    const double spring = std::pow(2 * std::numbers::pi * bandwidth, 2);
    const double damper = 2 * damping * 2 * std::numbers::pi * bandwidth;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const auto row = static_cast<unsigned>(i);
      const double most = 1.5 * parameters_[i].acceleration;  // a set point that jumps is no acceleration
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
