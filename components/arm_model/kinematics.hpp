// Where the tool of an arm is, and how it moves when the axes do, by the solvers of Orocos KDL.
#pragma once

#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include <Eigen/Core>

#include "arm_model/parameters.hpp"

namespace arm_model {

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

/// With masses, rotors and the frames of Axis.
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

/// How the axes have to turn so that the tool moves by `twist`, in the sense of least squares with a price on
/// turning: rad or rad/s. Real-time.
Vector6 rates(const Matrix6& jacobian, const Vector6& twist, double damping = 0) noexcept;

/// The constructor allocates; the rest is for real-time threads.
class Kinematics {
 public:
  explicit Kinematics(const Parameters& parameters);
  Kinematics(const Kinematics&) = delete;
  Kinematics& operator=(const Kinematics&) = delete;

  [[nodiscard]] const Parameters& parameters() const noexcept { return parameters_; }
  /// Of the tool in the foot.
  [[nodiscard]] KDL::Frame forward(const Joints& joints) noexcept;
  /// Velocity and angular velocity of the tool, in the axes of the foot, for each axis at 1 rad/s.
  [[nodiscard]] const Matrix6& jacobian(const Joints& joints) noexcept;

  /// How far from a singularity: the least that the tool moves when the axes together move by 1 rad. In m,
  /// where a turn by 1 rad counts as `lever` m.
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
