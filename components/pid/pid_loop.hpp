// The mathematics of the component pid: a PID controller in the ISA standard form. Real-time threads may use
// everything here.
#pragma once

#include <algorithm>
#include <cmath>

namespace pid {

/// Tuning of the controller u = gain (b r - y  +  1/Ti integral of (r - y)  -  Td dyf/dt), where r is the set
/// point, y the measurement, and yf the measurement after a low-pass of Td / N.
struct Tuning {
  double gain = 1;  ///< output per unit of y; negative if a rising output makes the process value fall
  double integral_time = 0;       ///< Ti, s; 0: no integral action
  double derivative_time = 0;     ///< Td, s
  double derivative_filter = 10;  ///< N, usually 2 to 20
  double setpoint_weight = 1;     ///< b, 0 to 1: fraction of a set point step that acts at once
  double tracking_time = 0;   ///< Tt, time constant of the anti-windup, s; 0: sqrt(Ti Td), or Ti if Td is 0
  double low = -1, high = 1;  ///< limits of the output, low < high

  bool operator==(const Tuning&) const = default;
};

/// Controls a process as Astroem and Haegglund describe in Advanced PID Control. The integral is trapezoidal
/// (bilinear), so it is exact for an error that changes linearly between releases. The derivative is a
/// backward difference, so it does not ring, however short its filter is compared with the period. The
/// anti-windup is exact for an output that exceeds its limit by a constant amount, so it is stable for any
/// tracking time.
class PidLoop {
 public:
  /// Sets the tuning for the following steps. The integral compensates for the change: for the inputs of the
  /// last step, both tunings give the same output. Without integral action, nothing compensates, and the
  /// output jumps after tune(), reset() and manual().
  void tune(const Tuning& tuning) noexcept {
    if (tuning == tuning_) return;
    const double before = proportional(setpoint_, measured_) + derivative();
    tuning_ = tuning;
    if (begun_) integral_ += before - proportional(setpoint_, measured_) - derivative();
    if (tuning_.integral_time <= 0) integral_ = 0;
  }
  /// Makes the next step the first step, with an output that begins at `output`.
  void reset(double output = 0) noexcept {
    begun_ = false;
    output_ = output;
  }
  /// Makes one step in automatic mode, `dt` s (above 0) after the last step. Returns the limited output.
  double automatic(double setpoint, double measured, double dt) noexcept {
    if (!begun_) begin(setpoint, measured);
    take(setpoint, measured, dt);
    const double wanted = proportional(setpoint, measured) + integral_ + derivative();
    output_ = std::clamp(wanted, tuning_.low, tuning_.high);
    if (tuning_.integral_time > 0 && wanted != output_)
      integral_ += (1 - std::exp(-dt / tracking_time())) * (output_ - wanted);
    return output_;
  }
  /// Makes one step in manual mode: the output is `value`, limited. The integral follows, so that automatic()
  /// continues from this output.
  double manual(double setpoint, double measured, double value, double dt) noexcept {
    if (!begun_) begin(setpoint, measured);
    take(setpoint, measured, dt);
    output_ = std::clamp(value, tuning_.low, tuning_.high);
    follow();
    return output_;
  }
  [[nodiscard]] double output() const noexcept { return output_; }

 private:
  void begin(double setpoint, double measured) noexcept {
    begun_ = true;
    setpoint_ = setpoint;
    measured_ = filtered_ = measured;
    output_ = std::clamp(output_, tuning_.low, tuning_.high);
    follow();
  }
  void take(double setpoint, double measured, double dt) noexcept {
    if (tuning_.integral_time > 0) {
      const double mean_error = ((setpoint_ - measured_) + (setpoint - measured)) / 2;
      integral_ += tuning_.gain * dt / tuning_.integral_time * mean_error;
    }
    const double filter_time = tuning_.derivative_time / tuning_.derivative_filter;
    filtered_ += dt / (filter_time + dt) * (measured - filtered_);
    setpoint_ = setpoint;
    measured_ = measured;
  }
  void follow() noexcept {
    if (tuning_.integral_time > 0) integral_ = output_ - proportional(setpoint_, measured_) - derivative();
  }
  [[nodiscard]] double proportional(double setpoint, double measured) const noexcept {
    return tuning_.gain * (tuning_.setpoint_weight * setpoint - measured);
  }
  // The difference between the filter's input and output equals the filter time times the slope of its
  // output.
  [[nodiscard]] double derivative() const noexcept {
    return tuning_.derivative_time > 0 ? -tuning_.gain * tuning_.derivative_filter * (measured_ - filtered_)
                                       : 0;
  }
  [[nodiscard]] double tracking_time() const noexcept {
    if (tuning_.tracking_time > 0) return tuning_.tracking_time;
    return tuning_.derivative_time > 0 ? std::sqrt(tuning_.integral_time * tuning_.derivative_time)
                                       : tuning_.integral_time;
  }

  Tuning tuning_;
  bool begun_ = false;
  double setpoint_ = 0, measured_ = 0;
  double filtered_ = 0;  // the measurement after the low-pass of the derivative
  double integral_ = 0;
  double output_ = 0;
};

}  // namespace pid
