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

/// The KDL chain of the arm, with masses, rotors and the frames of Axis.
KDL::Chain chain(const Parameters& parameters);

/// x, y, z in m; roll, pitch, yaw in rad about the fixed axes, in this order.
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

/// The axis motions (rad or rad/s) that move the tool by `twist`, by damped least squares. Real-time.
Vector6 rates(const Matrix6& jacobian, const Vector6& twist, double damping = 0) noexcept;

/// The constructor allocates; all other functions are real-time.
class Kinematics {
 public:
  explicit Kinematics(const Parameters& parameters);
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;

  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }
  /// The frame of the tool in the frame of the foot.
  [[nodiscard]] KDL::Frame forward(const Joints& joints) noexcept;
  /// Velocity and angular velocity of the tool in the frame of the foot, for each axis at 1 rad/s.
  [[nodiscard]] const Matrix6& jacobian(const Joints& joints) noexcept;

  /// Distance from a singularity: the smallest tool motion, in m, for a joint motion of length 1 rad. A turn
  /// of the tool by 1 rad counts as a motion of `lever` m.
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
