// The mathematics of the component notch: a filter that removes one frequency from a signal. Real-time
// threads may use everything here.
#pragma once

#include "../common/state_variable_filter.hpp"

namespace notch {

/// Limits of the frequency and the width, as fractions of the sampling rate. low_pass_filter.hpp gives the
/// reasons.
inline constexpr double kLowest = 1e-6;
inline constexpr double kHighest = 0.49;

/// Filters a signal. The gain is 0 at the frequency, -3 dB at two frequencies that are `width` apart, and 1
/// at 0 Hz and at half the sampling rate. These values are exact for the sampled signal, not only for the
/// analog model. Frequency and width may change between any two steps.
class NotchFilter {
 public:
  /// Sets the coefficients. `frequency` and `width` are in Hz, each from kLowest to kHighest times the
  /// sampling rate; `period` is in s.
  void design(double frequency, double width, double period) noexcept {
    const double g = common::prewarped(frequency, period);
    // The edges f1 and f2 are the frequencies at -3 dB. For them, tan(pi f1 T) tan(pi f2 T) = g^2, and the
    // difference of the two tangents is g times the damping. The formula for the tangent of a difference then
    // gives the damping for which f2 - f1 is the width.
    filter_.design(g, common::prewarped(width, period) * (1 + g * g) / g);
  }
  void reset() noexcept { begun_ = false; }
  double step(double input) noexcept {
    if (!begun_) {
      begun_ = true;
      filter_.settle(input);
    }
    return input - filter_.damping() * filter_.step(input).band;
  }

 private:
  bool begun_ = false;
  common::StateVariableFilter filter_;
};

}  // namespace notch
