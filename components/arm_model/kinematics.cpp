#include "arm_model/kinematics.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>

namespace arm_model {

KDL::Chain chain(const Parameters& parameters) {
  KDL::Chain chain;
  for (const Axis& axis : parameters) {
    const KDL::Vector centre{axis.centre[0], axis.centre[1], axis.centre[2]};
    const KDL::RotationalInertia inertia{axis.inertia[0], axis.inertia[1], axis.inertia[2]};
    const KDL::RigidBodyInertia body{axis.mass, centre, inertia};
    chain.addSegment(KDL::Segment{KDL::Joint{KDL::Joint::RotZ, 1, 0, axis.rotor},
                                  KDL::Frame::DH(axis.a, axis.alpha, axis.d, axis.theta), body});
  }
  return chain;
}

KDL::Frame frame(const Pose& pose) noexcept {
  return {KDL::Rotation::RPY(pose.roll, pose.pitch, pose.yaw), {pose.x, pose.y, pose.z}};
}

Pose pose(const KDL::Frame& frame) noexcept {
  Pose pose{.x = frame.p.x(), .y = frame.p.y(), .z = frame.p.z()};
  frame.M.GetRPY(pose.roll, pose.pitch, pose.yaw);
  return pose;
}

Vector6 rates(const Matrix6& jacobian, const Vector6& twist, double damping) noexcept {
  if (damping == 0) return jacobian.partialPivLu().solve(twist);
  Matrix6 square = jacobian.transpose() * jacobian;
  square.diagonal().array() += damping;
  return square.ldlt().solve(jacobian.transpose() * twist);
}

Kinematics::Kinematics(const Parameters& parameters) : parameters_(parameters), chain_(chain(parameters)) {}

KDL::Frame Kinematics::forward(const Joints& joints) noexcept {
  std::copy(joints.begin(), joints.end(), joints_.data.data());
  KDL::Frame frame;
  forward_.JntToCart(joints_, frame);
  return frame;
}

const Matrix6& Kinematics::jacobian(const Joints& joints) noexcept {
  std::copy(joints.begin(), joints.end(), joints_.data.data());
  jacobian_.JntToJac(joints_, columns_);
  result_ = columns_.data;
  return result_;
}

double Kinematics::dexterity(const Matrix6& jacobian, double lever) noexcept {
  Matrix6 scaled = jacobian;
  scaled.bottomRows<3>() *= lever;
  const Matrix6 square = scaled * scaled.transpose();
  const Eigen::SelfAdjointEigenSolver<Matrix6> solver{square, Eigen::EigenvaluesOnly};
  return std::sqrt(std::max(0.0, solver.eigenvalues()[0]));
}

}  // namespace arm_model
