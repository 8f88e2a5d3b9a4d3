// A notch filter: removes one frequency from a signal. For real-time threads.
#pragma once

#include "../common/state_variable_filter.hpp"

namespace notch {

inline constexpr double kLowest = 1e-6;  ///< fractions of the rate; see low_pass
inline constexpr double kHighest = 0.49;

/// The gain is 0 at the frequency, -3 dB at two frequencies that are `width` apart, and 1 at 0 Hz and at half
/// the rate. This holds for the sampled signal, not only for the analog model. Frequency and width may change
/// between any two steps.
class NotchFilter {
 public:
  /// Sets `frequency` and `width` in Hz and `period` in s. Both frequencies must be from kLowest to kHighest
  /// times the rate.
  void design(double frequency, double width, double period) noexcept {
    const double g = common::prewarped(frequency, period);
    // At the edges, tan(pi f1 T) tan(pi f2 T) = g^2, and the difference of the two tangents is g times the
    // damping. By the formula for the tangent of a difference, this damping makes their distance in Hz equal
    // to the width.
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
