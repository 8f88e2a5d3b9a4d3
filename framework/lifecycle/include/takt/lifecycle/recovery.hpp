// When a module in RECOVER is tried again, and when it is given up.
//
// A module that recovers at once and fails at once would be tried for ever if each success cleared the count,
// and one that fails once a month would be given up after three months if none did. So a success counts as
// lasting only after the module has run without an error for ten back-offs, at least a second.
#pragma once

#include <optional>

#include <takt/core/time.hpp>

namespace takt::lifecycle {

struct RecoveryPolicy {
  int attempts = 3;  ///< 0: an error gives the module up
  Nanoseconds backoff = std::chrono::milliseconds{100};
};

/// Counts the attempts of one module. The time is handed in.
class Recovery {
 public:
  enum class Step { wait, attempt, give_up };

  explicit Recovery(RecoveryPolicy policy) : policy_(policy) {}

  /// The module went to RECOVER. `since`: when it went wrong, if that was seen late, as with what does not
  /// come back: the time until then is no time without an error.
  void failed(Instant now, std::optional<Instant> since = std::nullopt) noexcept;
  /// An attempt ended: it is EXECUTING or START again, or still in RECOVER.
  void attempted(Instant now, bool recovered) noexcept;
  /// What to do now with a module that is in RECOVER. `attempt` counts it.
  Step next(Instant now) noexcept;

  /// The next attempt does not wait for its back-off.
  void hurry() noexcept { not_before_ = Instant{}; }

  /// Attempts since the last lasting success.
  [[nodiscard]] int attempts() const noexcept { return made_; }

 private:
  RecoveryPolicy policy_;
  int made_ = 0;
  Instant not_before_{};
  Instant recovered_at_{};
  bool running_ = true;  // since recovered_at_
};

}  // namespace takt::lifecycle
