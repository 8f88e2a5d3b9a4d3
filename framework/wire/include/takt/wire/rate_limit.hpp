// Limits the rate of commands that a node accepts, per client and in total. Not for other rooms.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>

namespace takt::wire {

/// A client that sends commands without end must not stop a node's other work, nor block other clients. So
/// each client has an allowance that refills with time. All clients together share another allowance.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;
  struct Bound {
    double per_second = 0;  ///< commands per second in the long term
    double burst = 0;       ///< commands at once after a pause
  };
  /// The allowance of each client: ten times the rate of an operator who watches a cell of 50 modules each
  /// second.
  static constexpr Bound kEach{100, 512};
  /// The allowance of all clients together.
  static constexpr Bound kAll{500, 2048};

  explicit RateLimit(Bound each = kEach, Bound all = kAll) : each_(each), all_{all, all.burst, {}} {}

  /// Whether to accept one more command. A rejected command does not use the other clients' allowance.
  bool admit(std::uint64_t client, Clock::time_point now);

 private:
  struct Allowance {
    Bound bound;
    double left = 0;
    Clock::time_point since{};
    void fill(Clock::time_point now);
  };

  Bound each_;
  Allowance all_;
  std::map<std::uint64_t, Allowance> clients_;
};

}  // namespace takt::wire
