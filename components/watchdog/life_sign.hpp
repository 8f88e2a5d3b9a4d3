// Whether something still gives signs of life. For real-time threads.
#pragma once

#include <cstdint>

namespace watchdog {

/// Neither alive nor dead before the first sign, for the time that there is for one.
class LifeSign {
 public:
  /// Times in nanoseconds: since the last step; within which a sign must come.
  void step(bool sign, std::int64_t passed_ns, std::int64_t timeout_ns) noexcept {
    silent_ns_ = sign ? 0 : silent_ns_ + passed_ns;
    dead_ = silent_ns_ > timeout_ns;
    seen_ = !dead_ && (seen_ || sign);
  }
  void reset() noexcept { *this = {}; }
  /// A sign came, and none has been missing since.
  [[nodiscard]] bool alive() const noexcept { return seen_; }
  /// None came in time.
  [[nodiscard]] bool dead() const noexcept { return dead_; }

 private:
  bool seen_ = false, dead_ = false;
  std::int64_t silent_ns_ = 0;
};

}  // namespace watchdog
