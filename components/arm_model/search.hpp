// Inverse kinematics: finds axis positions that bring the tool to a pose. No formula exists for arbitrary
// six-axis arms, so the search tries many starting points until one succeeds. The duration of a search cannot
// be predicted, so a real-time thread does a bounded part of the search each period. KDL's own search
// (ChainIkSolverPos_LMA) allocates memory and cannot stop before its end.
#pragma once

#include <cstddef>

#include "arm_model/kinematics.hpp"

namespace arm_model {

/// The state or the result of a search.
enum class Reach { searching, found, out_of_reach, joint_limit };

/// Searches with the Levenberg-Marquardt method. The search is deterministic: the same goal and start give
/// the same solution in the same number of steps. Real-time threads may call all functions, including the
/// constructor.
class Search {
 public:
  static constexpr std::size_t kStarts = 60;  ///< number of starting points
  static constexpr int kStepsPerStart = 60;   ///< maximum number of steps per starting point
  /// The search leaves a starting point after this many consecutive steps with little progress.
  static constexpr int kStalled = 8;
  static constexpr double kTolerance = 1e-9;  ///< m and rad, accuracy of a solution

  explicit Search(Kinematics& kinematics) noexcept : kinematics_(kinematics) {}

  /// Begins a search for `goal`. Prefers solutions near `near`.
  void begin(const KDL::Frame& goal, const Joints& near) noexcept;
  /// Rejects the solution that was found, and continues with the next starting point.
  void go_on() noexcept;
  /// Makes one step, in about 3 us: one Jacobian and one linear system of six equations.
  Reach step() noexcept;

  [[nodiscard]] const Joints& found() const noexcept { return joints_; }

  /// Makes one damped step of Newton's method from `joints` towards `goal`. Returns the new axis positions.
  /// Sets `error` to the distance of the tool from the goal before the step (the larger of m and rad).
  /// Real-time threads may call this function.
  static Joints newton(Kinematics& kinematics, const KDL::Frame& goal, const Joints& joints, double damping,
                       double& error) noexcept;

 private:
  void start() noexcept;
  bool within_limits() noexcept;
  Reach give_up() noexcept;

  Kinematics& kinematics_;
  KDL::Frame goal_;
  Joints near_{};
  Joints joints_{};
  Vector6 miss_ = Vector6::Zero();
  double damping_ = 0;
  int steps_ = 0;
  int stalled_ = 0;  // number of consecutive steps with little progress
  std::size_t start_ = 0;
  bool beyond_ = false;  // true: a solution was found, but it is outside the axis limits
};

}  // namespace arm_model
