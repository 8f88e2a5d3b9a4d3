// A second-order filter whose two states are those of its analog model, for low_pass and notch. For real-time
// threads.
#pragma once

#include <cmath>
#include <numbers>

namespace common {

/// The bilinear transform with prewarping maps the frequency f to tan(pi f / rate): a filter that is made so
/// has at f exactly the gain of its analog model.
inline double prewarped(double frequency, double period) noexcept {
  return std::tan(std::numbers::pi * frequency * period);
}

/// Two trapezoidal integrators in a loop: s'' + damping w s' + w^2 s = w^2 x, by the bilinear transform. A
/// filter in direct form holds old samples, which mean something else after its coefficients changed; the
/// states of this one are the low-pass and the band-pass output, and mean the same. So coefficients may
/// change between any two steps and the output goes on from where it is (Zavalishin, The Art of VA Filter
/// Design).
class StateVariableFilter {
 public:
  struct Output {
    double low, band;  ///< band: as steep as `damping` says, 1 / damping at its middle
  };

  /// `g`: prewarped() frequency, above 0; `damping`: 1 / quality, above 0.
  void design(double g, double damping) noexcept {
    g_ = g;
    damping_ = damping;
    scale_ = 1 / (1 + g * (g + damping));
  }
  /// At rest with this input: the next outputs are it and 0.
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
