// A notch: takes one frequency out of a signal. For real-time threads.
#pragma once

#include "../common/state_variable_filter.hpp"

namespace notch {

inline constexpr double kLowest = 1e-6;  ///< of the rate; see low_pass
inline constexpr double kHighest = 0.49;

/// Zero at its frequency, -3 dB at two frequencies that lie `width` apart, 1 at 0 Hz and at half the rate: in
/// the sampled signal, not only in the analog model. Frequency and width may change between any two steps.
class NotchFilter {
 public:
  /// Hz, Hz, s; both within kLowest and kHighest of the rate.
  void design(double frequency, double width, double period) noexcept {
    const double g = common::prewarped(frequency, period);
    // Edges are where tan(pi f1 T) tan(pi f2 T) = g^2 and the difference of the two is g times the damping;
    // by the theorem of the tangent of a difference their distance in Hz is the width for this damping.
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
