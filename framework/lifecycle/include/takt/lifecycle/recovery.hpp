// Decides when a module in RECOVER gets another recovery attempt, and when Takt gives the module up.
//
// If every success cleared the count, a module that fails right after each recovery would be tried for ever.
// If no success cleared the count, a module that fails once a month would be given up after three months. So
// only a lasting success clears the count: the module ran without an error for ten back-offs, and for at
// least a second.
#pragma once

#include <optional>

#include <takt/core/time.hpp>

namespace takt::lifecycle {

struct RecoveryPolicy {
  int attempts = 3;  ///< 0: the module is given up at its first error
  Nanoseconds backoff = std::chrono::milliseconds{100};
};

/// Counts the recovery attempts of one module. The caller passes the time in.
class Recovery {
 public:
  enum class Step { wait, attempt, give_up };

  explicit Recovery(RecoveryPolicy policy) : policy_(policy) {}

  /// Records that the module went to RECOVER at `now`. `since` is the time at which the error began, for an
  /// error that is noticed late, such as a hang. The time from `since` to `now` does not count as time
  /// without an error.
  void failed(Instant now, std::optional<Instant> since = std::nullopt) noexcept;
  /// Records that an attempt ended: the module is in EXECUTING or START again, or still in RECOVER.
  void attempted(Instant now, bool recovered) noexcept;
  /// What to do now with a module in RECOVER. The answer `attempt` counts as one attempt.
  Step next(Instant now) noexcept;

  /// Lets the next attempt begin without waiting for the back-off.
  void hurry() noexcept { not_before_ = Instant{}; }

  /// Attempts since the last lasting success.
  [[nodiscard]] int attempts() const noexcept { return made_; }

 private:
  RecoveryPolicy policy_;
  int made_ = 0;
  Instant not_before_{};
  Instant recovered_at_{};
  bool running_ = true;  // whether the module has run without an error since recovered_at_
};

}  // namespace takt::lifecycle
