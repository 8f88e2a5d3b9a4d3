// Monitors signs of life. For real-time threads.
#pragma once

#include <cstdint>

namespace watchdog {

/// Before the first sign the input is neither alive nor dead, for at most the timeout.
class LifeSign {
 public:
  /// `passed_ns`: time since the last step. `timeout_ns`: maximum time between two signs.
  void step(bool sign, std::int64_t passed_ns, std::int64_t timeout_ns) noexcept {
    silent_ns_ = sign ? 0 : silent_ns_ + passed_ns;
    dead_ = silent_ns_ > timeout_ns;
    seen_ = !dead_ && (seen_ || sign);
  }
  void reset() noexcept { *this = {}; }
  /// A sign has arrived, and none has been missing since.
  [[nodiscard]] bool alive() const noexcept { return seen_; }
  /// No sign arrived in time.
  [[nodiscard]] bool dead() const noexcept { return dead_; }

 private:
  bool seen_ = false, dead_ = false;
  std::int64_t silent_ns_ = 0;
};

}  // namespace watchdog
