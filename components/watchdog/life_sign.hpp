// The mathematics of the component watchdog: monitors signs of life. Real-time threads may use everything
// here.
#pragma once

#include <cstdint>

namespace watchdog {

/// Monitors one input. After the start, the input is neither alive nor dead until the first sign arrives or
/// the timeout has passed.
class LifeSign {
 public:
  /// Makes one step. `sign`: whether a sign has arrived; `passed_ns`: time since the last step; `timeout_ns`:
  /// maximum time between two signs.
  void step(bool sign, std::int64_t passed_ns, std::int64_t timeout_ns) noexcept {
    silent_ns_ = sign ? 0 : silent_ns_ + passed_ns;
    dead_ = silent_ns_ > timeout_ns;
    seen_ = !dead_ && (seen_ || sign);
  }
  void reset() noexcept { *this = {}; }
  /// Returns true if a sign has arrived, and the last one is not older than the timeout.
  [[nodiscard]] bool alive() const noexcept { return seen_; }
  /// Returns true if no sign has arrived for longer than the timeout.
  [[nodiscard]] bool dead() const noexcept { return dead_; }

 private:
  bool seen_ = false, dead_ = false;
  std::int64_t silent_ns_ = 0;
};

}  // namespace watchdog
