// Test signals. For real-time threads.
#pragma once

#include <cmath>
#include <numbers>

namespace signal_generator {

enum class Shape { sine, square, triangle, sawtooth, constant };

/// From -1 to 1, beginning at 0 rising where the shape allows it. `phase`: of a period, from 0 to below 1.
inline double shape_at(Shape shape, double phase) noexcept {
  switch (shape) {
    case Shape::sine:
      return std::sin(2 * std::numbers::pi * phase);
    case Shape::square:
      return phase < 0.5 ? 1 : -1;
    case Shape::triangle:
      return phase < 0.25 ? 4 * phase : phase < 0.75 ? 2 - 4 * phase : 4 * phase - 4;
    case Shape::sawtooth:
      return phase < 0.5 ? 2 * phase : 2 * phase - 2;
    case Shape::constant:
      return 0;
  }
  return 0;
}

/// The phase goes on from where it is when the frequency changes.
class Phase {
 public:
  /// `dt` s later at `frequency` Hz; the phase before that.
  double step(double frequency, double dt) noexcept {
    const double now = phase_;
    phase_ += frequency * dt;
    phase_ -= std::floor(phase_);
    return now;
  }

 private:
  double phase_ = 0;
};

}  // namespace signal_generator
