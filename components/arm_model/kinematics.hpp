// Forward kinematics and Jacobian of a six-axis arm, with the solvers of Orocos KDL.
#pragma once

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include <Eigen/Core>

#include "arm_model/parameters.hpp"

namespace arm_model {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// Returns the KDL chain of the arm, with its masses, its rotors and the frames that Axis defines.
KDL::Chain chain(const Parameters& parameters);

/// A pose of the tool: x, y, z in m; roll, pitch, yaw in rad about the fixed axes, in this order.
struct Pose {
  double x = 0;
  double y = 0;
  double z = 0;
  double roll = 0;
  double pitch = 0;
  double yaw = 0;
};
KDL::Frame frame(const Pose& pose) noexcept;
Pose pose(const KDL::Frame& frame) noexcept;

/// Returns the axis motions (rad or rad/s) that move the tool by `twist`, by damped least squares. Real-time
/// threads may call this function.
Vector6 rates(const Matrix6& jacobian, const Vector6& twist, double damping = 0) noexcept;

/// Computes the forward kinematics and the Jacobian of an arm. The constructor allocates memory; real-time
/// threads may call all other functions.
class Kinematics {
 public:
  explicit Kinematics(const Parameters& parameters);
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;

  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }
  /// Returns the frame of the tool in the frame of the foot.
  [[nodiscard]] KDL::Frame forward(const Joints& joints) noexcept;
  /// Returns one column per axis: the velocity and angular velocity of the tool, in the frame of the foot,
  /// while that axis turns at 1 rad/s.
  [[nodiscard]] const Matrix6& jacobian(const Joints& joints) noexcept;

  /// Returns the distance from a singularity: the smallest tool motion, in m, for a joint motion of length 1
  /// rad. A turn of the tool by 1 rad counts as a motion of `lever` m.
  [[nodiscard]] static double dexterity(const Matrix6& jacobian, double lever = 0.5) noexcept;

 private:
  Parameters parameters_;
  KDL::Chain chain_;
  KDL::ChainFkSolverPos_recursive forward_{chain_};
  KDL::ChainJntToJacSolver jacobian_{chain_};
  KDL::JntArray joints_{kAxes};
  KDL::Jacobian columns_{kAxes};
  Matrix6 result_ = Matrix6::Zero();
};

}  // namespace arm_model
