// Limits the rate of commands that a node accepts, per client and in total.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>

namespace takt::wire {

/// Limits the rate of accepted commands, so that a client that sends commands without pause neither keeps a
/// node from its other work nor blocks other clients. Each client has an allowance of commands that refills
/// over time. In addition, all clients share one common allowance.
class RateLimit {
 public:
  using Clock = std::chrono::steady_clock;
  struct Bound {
    double per_second = 0;  ///< accepted commands per second, as a long-term average
    double burst = 0;       ///< accepted commands in a burst after a pause
  };
  /// The allowance of each client: ten times the rate of an operator who watches a cell of 50 modules each
  /// second.
  static constexpr Bound kEach{100, 512};
  /// The common allowance of all clients.
  static constexpr Bound kAll{500, 2048};

  explicit RateLimit(Bound each = kEach, Bound all = kAll) : each_(each), all_{all, all.burst, {}} {}

  /// Returns true if the node should accept one more command of this client. A rejected command does not
  /// reduce the common allowance.
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
