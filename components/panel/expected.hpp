// The mathematics of panel: predicts how many parts a cell should have placed so far. Times in s. For
// real-time threads.
#pragma once

#include <algorithm>
#include <cstdint>

namespace panel {

/// The arm's plan for a part: the times from the request until the part is placed and until the arm is home.
struct ArmPlan {
  std::uint32_t number = 0;  ///< number of the part
  double placed = 0;
  double ended = 0;
};

/// Assumes that parts come one after the other. Each part is brought (belt, camera, messages) while the arm
/// goes home from the previous one. Then the arm needs the time of its plan. All times are known before the
/// part is placed. The time of an emergency stop does not count.
class Expected {
 public:
  /// The time from the placing of a part, or from the start, to the next pick request. 0: no prediction.
  void bring(double seconds) noexcept { bring_ = seconds; }

  /// The arm has begun a part. A repeated plan changes nothing.
  void planned(const ArmPlan& plan) noexcept {
    if (bring_ <= 0 || plan.number == last_.number) return;
    ++begun_;
    due_ += until_next() + plan.placed;
    last_ = plan;
  }
  void pass(double seconds, bool permitted) noexcept { (permitted ? running_ : stopped_) += seconds; }

  /// The number of parts that should be placed by now. For parts that the arm has not begun, it assumes the
  /// times of the last one.
  [[nodiscard]] std::uint32_t parts() const noexcept {
    if (begun_ == 0) return 0;
    if (running_ < due_) return begun_ - 1;
    return begun_ + static_cast<std::uint32_t>((running_ - due_) / (until_next() + last_.placed));
  }
  /// Average time from part to part so far; 0 before the first.
  [[nodiscard]] double part_time() const noexcept { return begun_ == 0 ? 0 : due_ / begun_; }
  /// The arm's time for the last part.
  [[nodiscard]] double arm_time() const noexcept { return last_.placed; }
  [[nodiscard]] double running() const noexcept { return running_; }
  [[nodiscard]] double stopped() const noexcept { return stopped_; }

 private:
  [[nodiscard]] double until_next() const noexcept { return std::max(bring_, last_.ended - last_.placed); }

  double bring_ = 0;
  ArmPlan last_;
  std::uint32_t begun_ = 0;  // number of parts that the arm has begun
  double due_ = 0;           // time from the start until the last of them should be placed
  double running_ = 0;
  double stopped_ = 0;
};

}  // namespace panel
