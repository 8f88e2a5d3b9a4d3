// What a bench module does when it is called: a small step of a filter, as a control module might.
#pragma once

namespace takt::bench {

class Work {
 public:
  /// About 50 ns. Real-time.
  void step() noexcept {
    for (double& value : state_) {
      input_ = value + 0.1 * (input_ - value);
      value = input_;
    }
    input_ = 1 - input_;
    output_ = input_;
  }

 private:
  double state_[16]{};
  double input_ = 1;
  volatile double output_ = 0;  // so that the work is done
};

}  // namespace takt::bench
