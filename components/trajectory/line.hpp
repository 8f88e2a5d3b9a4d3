// A straight line of the tool as a curve of axis positions. No formula exists for this curve, so a search
// computes its knots one at a time. Cubic splines with continuous accelerations join the knots. SI units,
// rad. Nothing here allocates memory.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "arm_model/search.hpp"

namespace trajectory {

using arm_model::Joints;
using arm_model::kAxes;
using arm_model::Kinematics;

/// The axis positions and their derivatives with respect to the parameter of the motion: the `s` of a line,
/// or time.
struct Point {
  Joints position{};
  Joints slope{};
  Joints bend{};  ///< derivative of the slope
};

/// A line from one tool pose to another with the same orientation. The parameter `s` is 0 at the beginning
/// and 1 at the end.
class Line {
 public:
  static constexpr std::size_t kPieces = 24;
  static constexpr int kNewtonSteps = 5;           ///< limit per knot; most knots take two or three
  static constexpr double kTolerance = 1e-10;      ///< m and rad, permitted error of the tool at a knot
  static constexpr double kFarthest = 0.3;         ///< rad, maximum axis move between two knots
  static constexpr double kLeastDexterity = 0.02;  ///< m, smallest permitted Kinematics::dexterity()

  enum class State { building, done, joint_limit, singular };

  /// Begins a line at `pose`, where the axes are at `joints`. `way` is the vector to the end of the line, in
  /// m, in the frame of the arm's foot.
  void begin(const KDL::Frame& pose, const KDL::Vector& way, const Joints& joints) noexcept {
    pose_ = pose;
    way_ = way;
    knots_[0] = joints;
    next_ = 0;
  }

  /// Computes the next knot; takes at most 30 us.
  State step(Kinematics& kinematics) noexcept {
    const KDL::Frame goal{pose_.M, pose_.p + way_ * (static_cast<double>(next_) / kPieces)};
    if (next_ > 0 && !approach(kinematics, goal)) return State::singular;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const arm_model::Axis& axis = kinematics.parameters()[i];
      if (knots_[next_][i] < axis.lower || knots_[next_][i] > axis.upper) return State::joint_limit;
    }
    const arm_model::Matrix6& jacobian = kinematics.jacobian(knots_[next_]);
    if (!(Kinematics::dexterity(jacobian) >= kLeastDexterity)) return State::singular;
    arm_model::Vector6 twist = arm_model::Vector6::Zero();
    for (int i = 0; i < 3; ++i) twist[i] = way_(i);
    const arm_model::Vector6 slope = arm_model::rates(jacobian, twist);
    std::copy(slope.begin(), slope.end(), slopes_[next_].begin());
    if (next_++ < kPieces) return State::building;
    smooth();
    return State::done;
  }

  [[nodiscard]] Point at(double s) const noexcept {
    const double place = std::clamp(s, 0.0, 1.0) * kPieces;
    const std::size_t i = std::min(static_cast<std::size_t>(place), kPieces - 1);
    const double t = place - static_cast<double>(i);
    Point point;
    for (std::size_t a = 0; a < kAxes; ++a) {
      const double from = knots_[i][a];
      const double by = knots_[i + 1][a] - from;
      const double begin = slopes_[i][a] / kPieces;
      const double end = slopes_[i + 1][a] / kPieces;
      const double square = 3 * by - 2 * begin - end;
      const double cube = begin + end - 2 * by;
      point.position[a] = from + t * (begin + t * (square + t * cube));
      point.slope[a] = kPieces * (begin + t * (2 * square + t * 3 * cube));
      point.bend[a] = kPieces * kPieces * (2 * square + t * 6 * cube);
    }
    return point;
  }
  [[nodiscard]] double length() const noexcept { return way_.Norm(); }

 private:
  /// Computes the next knot, with a linear guess from the previous knot. Returns false if the search finds no
  /// solution near the previous knot.
  bool approach(Kinematics& kinematics, const KDL::Frame& goal) noexcept {
    const Joints& before = knots_[next_ - 1];
    Joints joints = before;
    for (std::size_t i = 0; i < kAxes; ++i) joints[i] += slopes_[next_ - 1][i] / kPieces;
    double error = 1;
    for (int n = 0; n < kNewtonSteps && !(error < kTolerance); ++n)
      joints = arm_model::Search::newton(kinematics, goal, joints, 0, error);
    knots_[next_] = joints;
    for (std::size_t i = 0; i < kAxes; ++i)
      if (!(std::abs(joints[i] - before[i]) < kFarthest)) return false;
    return error < kTolerance;
  }

  /// Chooses the inner slopes so that the second derivative is continuous: solves a tridiagonal system for
  /// each axis by elimination.
  void smooth() noexcept {
    for (std::size_t a = 0; a < kAxes; ++a) {
      std::array<double, kPieces> factor{};
      for (std::size_t i = 1; i < kPieces; ++i) {
        const double pivot = 4 - factor[i - 1];
        factor[i] = 1 / pivot;
        slopes_[i][a] = (3.0 * kPieces * (knots_[i + 1][a] - knots_[i - 1][a]) - slopes_[i - 1][a]) / pivot;
      }
      for (std::size_t i = kPieces - 1; i > 0; --i) slopes_[i][a] -= factor[i] * slopes_[i + 1][a];
    }
  }

  KDL::Frame pose_;
  KDL::Vector way_;
  std::array<Joints, kPieces + 1> knots_{};
  std::array<Joints, kPieces + 1> slopes_{};  // derivatives with respect to s
  std::size_t next_ = 0;
};

}  // namespace trajectory
