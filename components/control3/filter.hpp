// The mathematics of the component control3: filters for the torque command of a resonant joint. Real-time
// threads may use everything here except low_pass() and notch(), which throw.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <stdexcept>

namespace control3 {

/// A second-order filter in transposed direct form II, designed with the bilinear transform and prewarping.
struct Biquad {
  double b0 = 1, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
  double s1 = 0, s2 = 0;

  /// Designs a low-pass filter. Its gain is 1 at 0 Hz, and -3 dB at `frequency` for a quality of 0.7071.
  /// Throws if the frequency is not below half the rate.
  static Biquad low_pass(double frequency, double quality, double rate) {
    const auto [cosine, alpha] = warp(frequency, quality, rate);
    const double a0 = 1 + alpha;
    return {.b0 = (1 - cosine) / 2 / a0,
            .b1 = (1 - cosine) / a0,
            .b2 = (1 - cosine) / 2 / a0,
            .a1 = -2 * cosine / a0,
            .a2 = (1 - alpha) / a0};
  }

  /// Designs a notch filter. Its gain is 0 at `frequency` and 1 far from it. Its half-power width is
  /// `frequency` / `quality`. Throws if the frequency is not below half the rate.
  static Biquad notch(double frequency, double quality, double rate) {
    const auto [cosine, alpha] = warp(frequency, quality, rate);
    const double a0 = 1 + alpha;
    return {
        .b0 = 1 / a0, .b1 = -2 * cosine / a0, .b2 = 1 / a0, .a1 = -2 * cosine / a0, .a2 = (1 - alpha) / a0};
  }

  double step(double input) noexcept {
    const double output = b0 * input + s1;
    s1 = b1 * input - a1 * output + s2;
    s2 = b2 * input - a2 * output;
    return output;
  }

  void reset() noexcept { s1 = s2 = 0; }

 private:
  struct Warped {
    double cosine, alpha;
  };
  static Warped warp(double frequency, double quality, double rate) {
    if (!(frequency > 0 && frequency < rate / 2)) {
      throw std::invalid_argument(
          "the frequency of a filter must be above 0 and below half the sampling rate");
    }
    if (!(quality > 0)) throw std::invalid_argument("the quality factor of a filter must be above 0");
    const double angle = 2 * std::numbers::pi * frequency / rate;
    return {std::cos(angle), std::sin(angle) / (2 * quality)};
  }
};

/// Generates a sine without calling sin(): each step rotates a vector and holds its length at 1.
struct Oscillator {
  double cosine = 1, sine = 0;  // cosine and sine of the rotation per step
  double x = 1, y = 0;

  Oscillator() = default;
  Oscillator(double frequency, double rate)
      : cosine(std::cos(2 * std::numbers::pi * frequency / rate)),
        sine(std::sin(2 * std::numbers::pi * frequency / rate)) {}

  double step() noexcept {
    const double nx = x * cosine - y * sine;
    const double ny = x * sine + y * cosine;
    const double correction = 1.5 - 0.5 * (nx * nx + ny * ny);  // one Newton step to length 1
    x = nx * correction;
    y = ny * correction;
    return y;
  }
};

/// Measures the amplitude of one frequency in a signal: multiplies the signal with a sine and a cosine and
/// averages the products over a whole number of periods.
struct Detector {
  double in_phase = 0, quadrature = 0;
  double amplitude = 0;          ///< amplitude in the last complete window
  std::uint64_t window = 10000;  ///< length of a window in steps
  std::uint64_t step_number = 0;

  void step(double signal, const Oscillator& reference) noexcept {
    in_phase += signal * reference.y;
    quadrature += signal * reference.x;
    if (++step_number < window) return;
    amplitude = 2 * std::hypot(in_phase, quadrature) / static_cast<double>(window);
    in_phase = quadrature = 0;
    step_number = 0;
  }
};

}  // namespace control3
