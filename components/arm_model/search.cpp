#include "arm_model/search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
namespace arm_model {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// Returns the difference between two poses: a translation in m, and a rotation in rad about an axis.
Vector6 between(const KDL::Frame& from, const KDL::Frame& to) noexcept {
  const KDL::Twist twist = KDL::diff(from, to);
  Vector6 result;
  for (int i = 0; i < 6; ++i) result[i] = twist(i);
  return result;
}

Joints moved(const Joints& joints, const Vector6& by) noexcept {
  Joints result = joints;
  for (std::size_t i = 0; i < kAxes; ++i) result[i] += by[static_cast<Eigen::Index>(i)];
  return result;
}

/// Returns the i-th point of a van der Corput sequence. For every n, the first n points fill the range 0 to 1
/// evenly. Each `base` gives a different sequence.
double evenly(std::size_t i, std::size_t base) noexcept {
  double result = 0;
  double share = 1;
  for (; i > 0; i /= base) {
    share /= static_cast<double>(base);
    result += share * static_cast<double>(i % base);
  }
  return result;
}

}  // namespace

Joints Search::newton(Kinematics& kinematics, const KDL::Frame& goal, const Joints& joints, double damping,
                      double& error) noexcept {
  const Vector6 miss = between(kinematics.forward(joints), goal);
  error = miss.cwiseAbs().maxCoeff();
  return moved(joints, rates(kinematics.jacobian(joints), miss, damping));
}

void Search::begin(const KDL::Frame& goal, const Joints& near) noexcept {
  goal_ = goal;
  near_ = near;
  beyond_ = false;
  start_ = 0;
  start();
}

void Search::go_on() noexcept {
  ++start_;
  start();
}

// Chooses the starting point. Point 0 is the present axis positions with the first axis turned towards the
// goal, and point 1 is the present axis positions. The other points are spread over the range of the axes.
void Search::start() noexcept {
  static constexpr std::size_t kBases[kAxes] = {2, 3, 5, 7, 11, 13};
  const Parameters& axes = kinematics_.parameters();
  joints_ = near_;
  if (start_ == 0) joints_[0] = std::atan2(goal_.p.y(), goal_.p.x()) - axes[0].theta;
  for (std::size_t i = 0; i < kAxes && start_ >= 2; ++i)
    joints_[i] = axes[i].lower + (axes[i].upper - axes[i].lower) * evenly(start_ - 1, kBases[i]);
  miss_ = between(kinematics_.forward(joints_), goal_);
  damping_ = 1e-2;
  steps_ = 0;
  stalled_ = 0;
}

Reach Search::step() noexcept {
  if (start_ >= kStarts) return give_up();
  Vector6 by = rates(kinematics_.jacobian(joints_), miss_, damping_);
  by *= std::min(1.0, 0.7 / by.cwiseAbs().maxCoeff());  // the Jacobian is accurate only for small steps
  const Joints next = moved(joints_, by);
  const Vector6 miss = between(kinematics_.forward(next), goal_);
  if (miss.squaredNorm() < miss_.squaredNorm()) {
    stalled_ = miss.norm() > 0.97 * miss_.norm() ? stalled_ + 1 : 0;
    joints_ = next;
    miss_ = miss;
    damping_ = std::max(damping_ * 0.1, 1e-14);
  } else {
    damping_ *= 8;
  }
  if (miss_.cwiseAbs().maxCoeff() < kTolerance) {
    if (within_limits()) return Reach::found;
    beyond_ = true;
    go_on();
  } else if (++steps_ >= kStepsPerStart || stalled_ >= kStalled || damping_ > 1e3) {
    go_on();
  }
  return start_ < kStarts ? Reach::searching : give_up();
}

Reach Search::give_up() noexcept { return beyond_ ? Reach::joint_limit : Reach::out_of_reach; }

/// Shifts each axis by full turns to a position near `near_` and within its limits. Returns false if an axis
/// has no such position.
bool Search::within_limits() noexcept {
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Axis& axis = kinematics_.parameters()[i];
    double joint = joints_[i] - kTurn * std::round((joints_[i] - near_[i]) / kTurn);
    if (joint > axis.upper) joint -= kTurn * std::ceil((joint - axis.upper) / kTurn);
    if (joint < axis.lower) joint += kTurn * std::ceil((axis.lower - joint) / kTurn);
    if (joint > axis.upper) return false;
    joints_[i] = joint;
  }
  return true;
}

}  // namespace arm_model
