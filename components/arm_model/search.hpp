// Inverse kinematics: finds axis positions that bring the tool to a pose. There is no formula for arbitrary
// six-axis arms, so it searches from many starting points until one succeeds. The time is not known in
// advance, so a real-time thread does a bounded piece of the search each period. KDL's own search
// (ChainIkSolverPos_LMA) allocates and returns only at its end.
#pragma once

#include <cstddef>

#include "arm_model/kinematics.hpp"

namespace arm_model {

/// The result of a search.
enum class Reach { searching, found, out_of_reach, joint_limit };

/// Uses the Levenberg-Marquardt method. It is deterministic: the same goal and start give the same answer in
/// the same number of steps. All functions are real-time, including the constructor.
class Search {
 public:
  static constexpr std::size_t kStarts = 60;  ///< number of starting points
  static constexpr int kStepsPerStart = 60;   ///< maximum
  static constexpr int kStalled =
      8;  ///< a starting point ends after this many consecutive steps with little progress
  static constexpr double kTolerance = 1e-9;  ///< m and rad, of the answer

  explicit Search(Kinematics& kinematics) noexcept : kinematics_(kinematics) {}

  /// Begins a search for `goal`. Prefers answers near `near`.
  void begin(const KDL::Frame& goal, const Joints& near) noexcept;
  /// Rejects the answer that was found and continues from the next starting point.
  void go_on() noexcept;
  /// One step, about 3 us: one Jacobian and one linear system of six.
  Reach step() noexcept;

  [[nodiscard]] const Joints& found() const noexcept { return joints_; }

  /// One step of Newton's method from `joints` to `goal`, with damping. Returns the new joints. Sets `error`
  /// to the distance of the tool from the goal before the step (the larger of m and rad). Real-time.
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
  int stalled_ = 0;  // consecutive steps with little progress
  std::size_t start_ = 0;
  bool beyond_ = false;  // an answer was found, but beyond the limits
};

}  // namespace arm_model
