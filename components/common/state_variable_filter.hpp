// A second-order filter whose two states are those of its analog model. low_pass and notch use it. For
// real-time threads.
#pragma once

#include <cmath>
#include <numbers>

namespace common {

/// The bilinear transform with prewarping maps the frequency f to tan(pi f / rate). At f, the filter then has
/// exactly the gain of its analog model.
inline double prewarped(double frequency, double period) noexcept {
  return std::tan(std::numbers::pi * frequency * period);
}

/// Two trapezoidal integrators in a loop: s'' + damping w s' + w^2 s = w^2 x, by the bilinear transform. The
/// states are the low-pass and the band-pass output, so they keep their meaning when the coefficients change.
/// The old samples in a direct-form filter do not. So coefficients may change between any two steps, and the
/// output continues without a jump (Zavalishin, The Art of VA Filter Design).
class StateVariableFilter {
 public:
  struct Output {
    double low, band;  ///< band: its gain at the centre frequency is 1 / damping
  };

  /// `g`: the prewarped() frequency, above 0; `damping`: 1 / quality, above 0.
  void design(double g, double damping) noexcept {
    g_ = g;
    damping_ = damping;
    scale_ = 1 / (1 + g * (g + damping));
  }
  /// Puts the filter at rest with this input: the next outputs are `input` (low) and 0 (band).
  void settle(double input) noexcept {
    band_state_ = 0;
    low_state_ = input;
  }
  Output step(double input) noexcept {
    const double difference = input - low_state_;
    const double band = scale_ * (band_state_ + g_ * difference);
    const double low = low_state_ + g_ * band;
    band_state_ = 2 * band - band_state_;
    low_state_ = 2 * low - low_state_;
    return {low, band};
  }
  [[nodiscard]] double damping() const noexcept { return damping_; }

 private:
  double g_ = 0, damping_ = 1, scale_ = 1;
  double band_state_ = 0, low_state_ = 0;
};

}  // namespace common
