// Measures the frequency response of a filter, for tests.
#pragma once

#include <cmath>
#include <complex>
#include <cstdint>
#include <numbers>

namespace common {

/// Returns the gain and phase of a filter as a complex number. Feeds the filter a sine with `cycles` whole
/// periods in `window` steps. After `settle` steps, correlates the output with that sine over one window. The
/// result is exact, apart from rounding errors.
template <class Step>
std::complex<double> frequency_response(Step&& step, int cycles, int window, int settle) {
  const double turn = 2 * std::numbers::pi * cycles / window;
  std::complex<double> sum = 0;
  for (int i = 0; i < settle + window; ++i) {
    const double angle = turn * (i % window);
    const double output = step(std::sin(angle));
    if (i >= settle) sum += output * std::polar(1.0, -angle);
  }
  // Scale the sum so that the result is 1 if the output equals the input sin(angle).
  return sum / std::complex<double>(0, -window / 2.0);
}

}  // namespace common
