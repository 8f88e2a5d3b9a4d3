// The mathematics of the component signal_generator. Real-time threads may use everything here.
#pragma once

#include <cmath>
#include <numbers>

namespace signal_generator {

enum class Shape { sine, square, triangle, sawtooth, constant };

/// Returns the value of the signal, from -1 to 1. `phase` is a fraction of a signal period, from 0 to below
/// 1. At phase 0, the sine, triangle and sawtooth rise through 0.
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

/// Tracks the phase of the signal. The phase stays continuous when the frequency changes.
class Phase {
 public:
  /// Advances the phase by `dt` s at `frequency` Hz. Returns the phase before the step.
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
