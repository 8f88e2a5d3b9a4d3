// Which positions of the axes bring the tool to a pose. There is no formula for any six axes, so it is
// searched for, from many starting points until one works out, and that takes a while that nobody knows
// beforehand. A real-time thread does a bounded piece of the search each period: KDL's own search
// (ChainIkSolverPos_LMA) allocates and comes back only at its end.
#pragma once

#include <cstddef>

#include "arm_model/kinematics.hpp"

namespace arm_model {

/// What a pose turned out to be.
enum class Reach { searching, found, out_of_reach, joint_limit };

/// By Levenberg and Marquardt's method. Same goal, same start: same answer in as many steps, on every run.
/// The constructor does not allocate; everything is for real-time threads.
class Search {
 public:
  static constexpr std::size_t kStarts = 60;  ///< starting points that are tried
  static constexpr int kStepsPerStart = 60;   ///< at most
  static constexpr int kStalled = 8;          ///< steps in a row that hardly help end one
  static constexpr double kTolerance = 1e-9;  ///< m and rad, of what is found

  explicit Search(Kinematics& kinematics) noexcept : kinematics_(kinematics) {}

  /// Of several answers those near `near` are preferred.
  void begin(const KDL::Frame& goal, const Joints& near) noexcept;
  /// The answer that was found will not do; from the next starting point on.
  void go_on() noexcept;
  /// One step, about 3 us: one Jacobian and one linear system of six.
  Reach step() noexcept;

  [[nodiscard]] const Joints& found() const noexcept { return joints_; }

  /// Of one step of Newton's method from `joints` to `goal`, damped by `damping`: the joints, and in `error`
  /// how far the tool was from the goal before (m and rad, the larger). Real-time.
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
  int stalled_ = 0;  // steps in a row that hardly helped
  std::size_t start_ = 0;
  bool beyond_ = false;  // an answer was found, beyond the limits
};

}  // namespace arm_model
