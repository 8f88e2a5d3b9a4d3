// How many commands a node takes, of one asker and in all. Not for other rooms.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>

namespace takt::dds {

/// Somebody who asks without end must not keep a node from anything else, nor from the commands of others. So
/// each asker has an allowance that fills again with time, and so have all together.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;
  struct Bound {
    double a_second = 0;  ///< in the long run
    double at_once = 0;   ///< after a pause
  };
  /// Ten times what an operator asks that looks at a cell of 50 modules each second.
  static constexpr Bound kEach{100, 512};
  static constexpr Bound kAll{500, 2048};

  explicit RateLimit(Bound each = kEach, Bound all = kAll) : each_(each), all_{all, all.at_once, {}} {}

  /// Whether one more is taken. What one asker has too much is not taken from the others' allowance.
  bool admit(std::uint64_t asker, Clock::time_point now);

 private:
  struct Allowance {
    Bound bound;
    double left = 0;
    Clock::time_point since{};
    void fill(Clock::time_point now);
  };

  Bound each_;
  Allowance all_;
  std::map<std::uint64_t, Allowance> askers_;
};

}  // namespace takt::dds
