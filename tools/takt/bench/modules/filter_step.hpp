// The work of a module in a benchmark: a small filter step, as in a control module.
#pragma once

namespace takt::bench {

class Work {
 public:
  /// Makes one step, which takes about 50 ns. Real-time code may call it.
  void step() noexcept { input_ = 1 - step(input_); }
  /// Makes one step with this input and returns the output.
  double step(double input) noexcept {
    for (double& value : state_) {
      input = value + 0.1 * (input - value);
      value = input;
    }
    output_ = input;
    return input;
  }

 private:
  double state_[16]{};
  double input_ = 1;
  volatile double output_ = 0;  // volatile, so that the compiler does not remove the work
};

}  // namespace takt::bench
