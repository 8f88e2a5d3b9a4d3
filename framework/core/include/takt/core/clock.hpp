// The clock interface for code that must also run on virtual time.
#pragma once

#include <takt/core/time.hpp>

namespace takt {

/// The machine's clock implements it, and so do the virtual clocks of tests and simulation.
class Clock {
 public:
  virtual ~Clock() = default;
  /// The current time. Real-time threads call it, so it must not lock, allocate or make a system call.
  virtual Instant now() noexcept = 0;
};

}  // namespace takt
