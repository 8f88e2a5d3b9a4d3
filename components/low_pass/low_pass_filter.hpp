// The mathematics of the component low_pass: a Butterworth low-pass of first or second order. Real-time
// threads may use everything here.
#pragma once

#include <numbers>

#include "../common/state_variable_filter.hpp"

namespace low_pass {

/// Limits of the cut-off frequency, as fractions of the sampling rate. Above the upper limit, tan() in the
/// bilinear transform diverges. Below the lower limit, the change per step is too small for a double.
inline constexpr double kLowest = 1e-6;
inline constexpr double kHighest = 0.49;

/// Filters a signal. The filter starts as if its first input had always been present. The cut-off frequency
/// and the order may change between any two steps; the output continues without a jump.
class LowPassFilter {
 public:
  /// Sets the coefficients. `cutoff` is in Hz, from kLowest to kHighest times the sampling rate; `period` is
  /// in s; `order` is 1 or 2.
  void design(double cutoff, double period, int order) noexcept {
    const double g = common::prewarped(cutoff, period);
    if (order != order_) {
      state_ = output_;
      second_.settle(output_);
    }
    order_ = order;
    share_ = g / (1 + g);
    second_.design(g, std::numbers::sqrt2);
  }
  void reset() noexcept { begun_ = false; }
  double step(double input) noexcept {
    if (!begun_) {
      begun_ = true;
      state_ = input;
      second_.settle(input);
    }
    if (order_ == 1) {
      const double change = share_ * (input - state_);
      output_ = state_ + change;
      state_ = output_ + change;
    } else {
      output_ = second_.step(input).low;
    }
    return output_;
  }

 private:
  int order_ = 0;
  bool begun_ = false;
  double share_ = 0, state_ = 0, output_ = 0;
  common::StateVariableFilter second_;
};

}  // namespace low_pass
