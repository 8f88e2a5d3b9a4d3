// Counts the periods since the last call of a component. Real-time threads may use everything here.
#pragma once

#include <algorithm>
#include <cstdint>

namespace common {

/// Counts periods by the numbers of the releases, because missed releases have numbers too. A component that
/// only counted its own calls would lose the time of missed releases.
class Releases {
 public:
  /// Returns the number of releases since the last call, at least 1; the first call returns 1. `number` is
  /// the number of the present release.
  std::uint64_t step(std::uint64_t number) noexcept {
    const std::uint64_t passed = known_ && number > last_ ? number - last_ : 1;
    last_ = number;
    known_ = true;
    return passed;
  }
  /// Makes the next call count as the first.
  void reset() noexcept { known_ = false; }

 private:
  std::uint64_t last_ = 0;
  bool known_ = false;
};

/// The maximum number of steps per call, for a component that computes one step for each release that has
/// passed. The maximum bounds the run time after many missed releases.
inline constexpr std::uint64_t kMostSteps = 32;
inline std::uint64_t steps_for(std::uint64_t passed) noexcept { return std::min(passed, kMostSteps); }

}  // namespace common
