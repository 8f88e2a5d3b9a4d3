// A second-order filter with the same two states as its analog model. The components low_pass and notch use
// it. Real-time threads may use everything here.
#pragma once

#include <cmath>
#include <numbers>

namespace common {

/// Returns tan(pi f / rate): the bilinear transform with prewarping maps the frequency f to this value. At f,
/// the filter then has exactly the gain of its analog model.
inline double prewarped(double frequency, double period) noexcept {
  return std::tan(std::numbers::pi * frequency * period);
}

/// Two trapezoidal integrators in a loop: s'' + damping w s' + w^2 s = w^2 x, by the bilinear transform. The
/// two states are the outputs of the low-pass and the band-pass. They keep their meaning when the
/// coefficients change, unlike the old samples in a direct-form filter. So coefficients may change between
/// any two steps, and the output continues without a jump (Zavalishin, The Art of VA Filter Design).
class StateVariableFilter {
 public:
  struct Output {
    double low, band;  ///< `band` has the gain 1 / damping at the centre frequency
  };

  /// Sets the coefficients. `g` is the prewarped() frequency, above 0; `damping` is 1 / quality, above 0.
  void design(double g, double damping) noexcept {
    g_ = g;
    damping_ = damping;
    scale_ = 1 / (1 + g * (g + damping));
  }
  /// Settles the filter for this constant input: its next outputs are `input` (low) and 0 (band).
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
