// A simulated process to try a controller on. For real-time threads.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

namespace process_model {

/// dy/dt = (gain u - y) / time_constant, with u delayed by a dead time: a good model for most temperature,
/// flow or speed loops. It is exact for an input that is constant between steps.
class FirstOrder {
 public:
  static constexpr std::size_t kMostDelay = 4096;  ///< maximum dead time, in steps

  /// `delay`: the dead time in steps, at most kMostDelay. `dt` and `time_constant` are in s, both above 0.
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
