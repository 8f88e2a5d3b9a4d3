// What a bench module does when it is called: a small step of a filter, as a control module might.
#pragma once

namespace takt::bench {

class Work {
 public:
  /// About 50 ns. Real-time.
  void step() noexcept { input_ = 1 - step(input_); }
  /// The same with an input from elsewhere; returns the output.
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
  volatile double output_ = 0;  // so that the work is done
};

}  // namespace takt::bench
