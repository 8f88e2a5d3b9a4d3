// A process that a controller can be tried on. For real-time threads.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace process_model {

/// dy/dt = (gain u - y) / time_constant, u dead_time later: what most loops of temperature, flow or speed
/// look like. Exact for an input that stands still between steps.
class FirstOrder {
 public:
  static constexpr std::size_t kMostDelay = 4096;  ///< steps of dead time

  /// `delay`: in steps, at most kMostDelay. `dt` and the time constant in s, both above 0.
  double step(double input, double gain, double time_constant, std::size_t delay, double dt) noexcept {
    delayed_[at_] = input;
    const double acts = delayed_[(at_ + delayed_.size() - delay) % delayed_.size()];
    at_ = (at_ + 1) % delayed_.size();
    output_ += -std::expm1(-dt / time_constant) * (gain * acts - output_);
    return output_;
  }
  void reset() noexcept { *this = {}; }
  [[nodiscard]] double output() const noexcept { return output_; }

 private:
  std::array<double, kMostDelay + 1> delayed_{};
  std::size_t at_ = 0;
  double output_ = 0;
};

}  // namespace process_model
