// Decides when Takt makes the next attempt to recover a module in RECOVER, and when Takt gives the module up.
//
// Recovery attempts are counted. If every successful attempt cleared the count, Takt would try for ever to
// recover a module that fails right after each recovery. If no success cleared the count, Takt would give up
// a module that fails once a month after three months. So only a lasting success clears the count: the module
// has run without an error for ten back-off times, and for at least a second.
#pragma once

#include <optional>

#include <takt/core/time.hpp>

namespace takt::lifecycle {

struct RecoveryPolicy {
  int attempts = 3;  ///< 0: Takt gives the module up at its first error
  Nanoseconds backoff = std::chrono::milliseconds{100};
};

/// Counts the recovery attempts of one module. The caller passes the current time.
class Recovery {
 public:
  enum class Step { wait, attempt, give_up };

  explicit Recovery(RecoveryPolicy policy) : policy_(policy) {}

  /// Records that the module went to RECOVER at `now`. If the error was detected late, as for a module that
  /// hangs, `since` is the time at which the error began. The time from `since` to `now` does not count as
  /// time without an error.
  void failed(Instant now, std::optional<Instant> since = std::nullopt) noexcept;
  /// Records that an attempt ended. `recovered` is true if the module has left RECOVER (for EXECUTING or
  /// START), and false if it is still in RECOVER.
  void attempted(Instant now, bool recovered) noexcept;
  /// Decides what to do now with a module in RECOVER. Each time the result is `attempt`, it counts as one
  /// attempt, unless `counts` is false: the cause of the error has ended by itself.
  Step next(Instant now, bool counts = true) noexcept;

  /// Allows the next attempt to begin at once, without waiting for the back-off time.
  void hurry() noexcept { not_before_ = Instant{}; }

  /// The number of counted attempts since the last lasting success.
  [[nodiscard]] int attempts() const noexcept { return made_; }

 private:
  RecoveryPolicy policy_;
  int made_ = 0;
  Instant not_before_{};
  Instant recovered_at_{};
  bool running_ = true;  // true if the module has run without an error since recovered_at_
};

}  // namespace takt::lifecycle
