// A clock interface for code that must also run on virtual time.
#pragma once

#include <takt/core/time.hpp>

namespace takt {

/// A source of the current time: the machine's clock, or the virtual clock of a test or simulation.
class Clock {
 public:
  virtual ~Clock() = default;
  /// The current time. Real-time threads call this, so an implementation must not lock, allocate memory or
  /// make a system call.
  virtual Instant now() noexcept = 0;
};

}  // namespace takt
