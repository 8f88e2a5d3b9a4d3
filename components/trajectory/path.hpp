// The way of a six-axis arm that takes parts off a belt: what trajectory computes every period, without the
// module around it. rad and s. Everything here is for real-time threads.
#pragma once

#include <array>
#include <cstddef>

namespace trajectory {

inline constexpr std::size_t kAxes = 6;
using Joints = std::array<double, kAxes>;

/// From 0 to 1 over 0 to 1, with no velocity and no acceleration at either end.
constexpr double quintic(double s) noexcept { return s * s * s * (10 + s * (-15 + 6 * s)); }
constexpr double quintic_slope(double s) noexcept { return 30 * s * s * (1 - s) * (1 - s); }

struct Point {
  Joints position{};
  Joints velocity{};
};

/// One cycle: from home over the belt, down, up, to the pallet and home again.
class Path {
 public:
  static constexpr std::size_t kLegs = 5;

  static constexpr Joints kHome{0, -1.2, 1.6, 0, 1.1, 0};
  static constexpr Joints kAbove{0.6, -0.9, 1.5, 0, 0.9, 0.6};
  static constexpr Joints kAtPart{0.6, -0.7, 1.6, 0, 0.7, 0.6};
  static constexpr Joints kPallet{-0.9, -0.7, 1.5, 0, 0.8, -0.9};

  /// Begins a cycle for a part that lies `offset` m beside the belt's middle (the arm turns to it; 1 m of
  /// reach), each leg taking `leg_seconds`.
  constexpr void begin(double offset, double leg_seconds) noexcept {
    offset_ = offset;
    leg_ = leg_seconds;
    time_ = 0;
    busy_ = true;
  }
  [[nodiscard]] constexpr bool busy() const noexcept { return busy_; }
  /// Whether the part has been put down: true for one step of a cycle.
  [[nodiscard]] constexpr bool put_down() const noexcept { return put_down_; }

  constexpr Point step(double dt) noexcept {
    put_down_ = false;
    if (!busy_) return {kHome, {}};
    const double before = time_;
    time_ += dt;
    if (before < 4 * leg_ && time_ >= 4 * leg_) put_down_ = true;
    if (time_ >= kLegs * leg_) {
      busy_ = false;
      return {kHome, {}};
    }
    const auto leg = static_cast<std::size_t>(time_ / leg_);
    const double s = time_ / leg_ - static_cast<double>(leg);
    const Joints from = corner(leg);
    const Joints to = corner(leg + 1);
    Point point;
    for (std::size_t i = 0; i < kAxes; ++i) {
      point.position[i] = from[i] + (to[i] - from[i]) * quintic(s);
      point.velocity[i] = (to[i] - from[i]) * quintic_slope(s) / leg_;
    }
    return point;
  }

 private:
  [[nodiscard]] constexpr Joints corner(std::size_t index) const noexcept {
    Joints joints = kHome;
    if (index == 1 || index == 3) joints = kAbove;
    if (index == 2) joints = kAtPart;
    if (index == 4) joints = kPallet;
    if (index >= 1 && index <= 3) joints[0] += offset_;
    return joints;
  }

  double offset_ = 0;
  double leg_ = 0.4;
  double time_ = 0;
  bool busy_ = false;
  bool put_down_ = false;
};

}  // namespace trajectory
