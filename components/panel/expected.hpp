// How many parts a cell should have placed: what panel shows beside those that it has. Times in s. For
// real-time threads.
#pragma once

#include <algorithm>
#include <cstdint>

namespace panel {

/// What the arm says when it begins with a part: when it will have placed it and when it will be home again,
/// from then.
struct ArmPlan {
  std::uint32_t number = 0;  ///< of the part
  double placed = 0;
  double ended = 0;
};

/// Parts come one after the other. Each is brought (belt, camera, messages) while the arm goes home from the
/// one before, then taken for as long as the arm's plan says. All of it is known before the part is placed.
/// Time in which nothing may run does not count.
class Expected {
 public:
  /// From a part's being placed, or from the start, to the next one's being asked for. 0: nothing is
  /// expected.
  void bring(double seconds) noexcept { bring_ = seconds; }

  /// The arm has begun with a part. What is told again changes nothing.
  void planned(const ArmPlan& plan) noexcept {
    if (bring_ <= 0 || plan.number == last_.number) return;
    ++begun_;
    due_ += until_next() + plan.placed;
    last_ = plan;
  }
  void pass(double seconds, bool permitted) noexcept { (permitted ? running_ : stopped_) += seconds; }

  /// Parts that should have been placed by now; of those that the arm has not begun with as many as fit at
  /// the last one's times.
  [[nodiscard]] std::uint32_t parts() const noexcept {
    if (begun_ == 0) return 0;
    if (running_ < due_) return begun_ - 1;
    return begun_ + static_cast<std::uint32_t>((running_ - due_) / (until_next() + last_.placed));
  }
  /// From part to part so far, on average; 0 before the first.
  [[nodiscard]] double part_time() const noexcept { return begun_ == 0 ? 0 : due_ / begun_; }
  /// Of the last part.
  [[nodiscard]] double arm_time() const noexcept { return last_.placed; }
  [[nodiscard]] double running() const noexcept { return running_; }
  [[nodiscard]] double stopped() const noexcept { return stopped_; }

 private:
  [[nodiscard]] double until_next() const noexcept { return std::max(bring_, last_.ended - last_.placed); }

  double bring_ = 0;
  ArmPlan last_;
  std::uint32_t begun_ = 0;  // parts that the arm has begun with
  double due_ = 0;           // when the last of them is to be placed, from the start
  double running_ = 0;
  double stopped_ = 0;
};

}  // namespace panel
