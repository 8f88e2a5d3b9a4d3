// A clock interface for code that runs on real time or, in tests and simulations, on virtual time.
#pragma once

#include <takt/core/time.hpp>

namespace takt {

/// A source of the current time: the machine's clock, or the virtual clock of a test or simulation.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Returns the current time. Real-time threads call this function, so an implementation must not lock,
  /// allocate memory or make a system call.
  virtual Instant now() noexcept = 0;
};

}  // namespace takt
