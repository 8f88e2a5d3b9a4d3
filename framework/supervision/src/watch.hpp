// Measures how long a value stays the same while the node looks at it.
//
// If the whole machine pauses, as a virtual machine may, a run seems to have lasted for the whole pause when
// the machine continues. So the time between two looks does not always count in full.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include <takt/core/time.hpp>

namespace takt::supervision {

class Watch {
 public:
  /// Returns for how long the value has been seen unchanged. `passed` is the time since the last look, and
  /// counts for at most a quarter of `limit`. `ran` is the CPU time of the thread that should change the
  /// value, if the thread is ready to run. Then at most the CPU time since the last look counts.
  Nanoseconds look(std::uint64_t value, Nanoseconds passed, Nanoseconds limit,
                   std::optional<Nanoseconds> ran = std::nullopt) noexcept {
    Nanoseconds counts = std::min(passed, limit / 4);
    if (ran) counts = std::min(counts, *ran - ran_);
    same_ = value == value_ ? same_ + counts : Nanoseconds{0};
    value_ = value;
    ran_ = ran.value_or(ran_);
    return same_;
  }
  /// For how long the value has been seen unchanged at the last look.
  [[nodiscard]] Nanoseconds seen_for() const noexcept { return same_; }

 private:
  std::uint64_t value_ = 0;
  Nanoseconds same_{};
  Nanoseconds ran_{};
};

/// The watches over one executor.
struct ExecutorWatch {
  Watch row;       ///< watches the run in progress in the thread of the rows
  Watch sporadic;  ///< watches the run in progress in the thread of the sporadic modules
  Watch cycles;    ///< watches the number of executed rows
};

}  // namespace takt::supervision
