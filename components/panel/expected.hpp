// The mathematics of the component panel: predicts how many parts a cell should have placed so far. Times are
// in s. Real-time threads may use everything here.
#pragma once

#include <algorithm>
#include <cstdint>

namespace panel {

/// The arm's plan for a part. The times run from the pick request until the part is placed, and until the arm
/// is home.
struct ArmPlan {
  std::uint32_t number = 0;  ///< number of the part
  double placed = 0;
  double ended = 0;
};

/// Predicts the number of placed parts. The prediction assumes that parts come one after the other: while the
/// arm goes home from one part, the belt brings the next one. Then the arm needs the time of its plan. All
/// these times are known before the arm places the part. The time of an emergency stop does not count.
class Expected {
 public:
  /// Sets the expected time from placing a part, or from the start, to the next pick request. 0 turns the
  /// prediction off.
  void bring(double seconds) noexcept { bring_ = seconds; }

  /// Records that the arm has begun a part. A repeated plan has no effect.
  void planned(const ArmPlan& plan) noexcept {
    if (bring_ <= 0 || plan.number == last_.number) return;
    ++begun_;
    due_ += until_next() + plan.placed;
    last_ = plan;
  }
  void pass(double seconds, bool permitted) noexcept { (permitted ? running_ : stopped_) += seconds; }

  /// Returns the number of parts that should be placed by now. Assumes that the parts that the arm has not
  /// begun take as long as the last one.
  [[nodiscard]] std::uint32_t parts() const noexcept {
    if (begun_ == 0) return 0;
    if (running_ < due_) return begun_ - 1;
    return begun_ + static_cast<std::uint32_t>((running_ - due_) / (until_next() + last_.placed));
  }
  /// Returns the average time from part to part so far; 0 before the first part.
  [[nodiscard]] double part_time() const noexcept { return begun_ == 0 ? 0 : due_ / begun_; }
  /// Returns the time that the arm needed for the last part.
  [[nodiscard]] double arm_time() const noexcept { return last_.placed; }
  [[nodiscard]] double running() const noexcept { return running_; }
  [[nodiscard]] double stopped() const noexcept { return stopped_; }

 private:
  [[nodiscard]] double until_next() const noexcept { return std::max(bring_, last_.ended - last_.placed); }

  double bring_ = 0;
  ArmPlan last_;
  std::uint32_t begun_ = 0;  // number of parts that the arm has begun
  double due_ = 0;           // time at which the last of these parts should be placed, from the start
  double running_ = 0;
  double stopped_ = 0;
};

}  // namespace panel
