// Counts the periods since a block's last call. For real-time threads.
#pragma once

#include <algorithm>
#include <cstdint>

namespace common {

/// Counts releases by their numbers in the grid, in which a missed release leaves a gap. A block that only
/// counted its calls would lose that time.
class Releases {
 public:
  /// Returns the number of releases since the last call; `number` is that of the present release. Returns at
  /// least 1, and 1 at the first call.
  std::uint64_t step(std::uint64_t number) noexcept {
    const std::uint64_t passed = known_ && number > last_ ? number - last_ : 1;
    last_ = number;
    known_ = true;
    return passed;
  }
  /// The next call counts as the first.
  void reset() noexcept { known_ = false; }

 private:
  std::uint64_t last_ = 0;
  bool known_ = false;
};

/// The maximum number of steps for a block that computes one step per release that has passed. It bounds the
/// run time after a long gap.
inline constexpr std::uint64_t kMostSteps = 32;
inline std::uint64_t steps_for(std::uint64_t passed) noexcept { return std::min(passed, kMostSteps); }

}  // namespace common
