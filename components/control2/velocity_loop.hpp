// The mathematics of the component control2: the velocity loop of a DC motor. SI units. Real-time threads may
// use everything here.
#pragma once

#include <algorithm>
#include <cmath>

namespace control2 {

/// A brushed 24 V motor of about 100 W with its load. Each step integrates the current first and then the
/// speed, with the new current. The integration is stable for steps up to twice the electrical time constant.
struct Motor {
  double resistance = 0.6;     ///< ohm
  double inductance = 0.6e-3;  ///< H
  double constant = 0.05;      ///< V s = N m / A, motor constant
  double inertia = 1e-4;       ///< kg m^2
  double friction = 1e-4;      ///< N m s, viscous friction
  double load = 0;             ///< N m, acts against positive speed

  double current = 0;  ///< A
  double speed = 0;    ///< rad/s

  void step(double voltage, double dt) noexcept {
    current += (voltage - resistance * current - constant * speed) / inductance * dt;
    speed += (constant * current - friction * speed - load) / inertia * dt;
  }
};

/// A PID controller with limited output. The derivative acts on the filtered measurement, so a set point step
/// causes no derivative kick. Anti-windup by back-calculation removes the excess over the limit from the
/// integral with the time constant `tracking`.
struct Pid {
  double gain = 0.2;           ///< V s/rad
  double integral_gain = 10;   ///< V/rad
  double derivative_gain = 0;  ///< V s^2/rad
  double filter = 0.5e-3;      ///< s, time constant of the derivative's filter
  double tracking = 0.02;      ///< s, time constant of the anti-windup
  double limit = 24;           ///< V, limit of the output

  double integral = 0;  ///< V
  double slope = 0;     ///< rad/s^2, the filtered derivative
  double last = 0;      ///< rad/s, the last measurement

  double step(double wanted, double measured, double dt) noexcept {
    const double error = wanted - measured;
    slope += ((measured - last) / dt - slope) * dt / (filter + dt);
    last = measured;
    const double free = gain * error + integral - derivative_gain * slope;
    const double bounded = std::clamp(free, -limit, limit);
    integral += (integral_gain * error + (bounded - free) / tracking) * dt;
    return bounded;
  }

  void reset() noexcept { integral = slope = last = 0; }
};

/// Measures the mean square of an error with a time constant of one second, and the largest absolute value of
/// the error.
struct ErrorMeter {
  double mean_square = 0;
  double largest = 0;

  void step(double error, double dt) noexcept {
    mean_square += (error * error - mean_square) * std::min(1.0, dt);
    largest = std::max(largest, std::abs(error));
  }
};

}  // namespace control2
