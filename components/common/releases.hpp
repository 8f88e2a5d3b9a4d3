// How many periods have passed since a block was called last. For real-time threads.
#pragma once

#include <algorithm>
#include <cstdint>

namespace common {

/// A release that was missed leaves a gap in the numbers of the grid; a block that counts time by its calls
/// alone would lose that time.
class Releases {
 public:
  /// Of the release `number`: how many have passed since the last call, at least 1; 1 at the first.
  std::uint64_t step(std::uint64_t number) noexcept {
    const std::uint64_t passed = known_ && number > last_ ? number - last_ : 1;
    last_ = number;
    known_ = true;
    return passed;
  }
  /// The next one is the first.
  void reset() noexcept { known_ = false; }

 private:
  std::uint64_t last_ = 0;
  bool known_ = false;
};

/// For what is computed step by step: as many steps as releases have passed, up to this many. So a long gap
/// does not make the call that follows it a long one.
inline constexpr std::uint64_t kMostSteps = 32;
inline std::uint64_t steps_for(std::uint64_t passed) noexcept { return std::min(passed, kMostSteps); }

}  // namespace common
