// The mathematics of the component process_model: a simulated process on which to test a controller.
// Real-time threads may use everything here.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace process_model {

/// Simulates dy/dt = (gain u - y) / time_constant, with u delayed by a dead time. This equation is a good
/// model for most temperature, flow or speed loops. The result is exact if the input is constant between
/// steps.
class FirstOrder {
 public:
  static constexpr std::size_t kMostDelay = 4096;  ///< maximum dead time, in steps

  /// Makes one step and returns the output. `delay` is the dead time in steps, at most kMostDelay. `dt` and
  /// `time_constant` are in s, both above 0.
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
