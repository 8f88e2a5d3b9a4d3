// Where code that must also run on virtual time reads the time.
#pragma once

#include <takt/core/time.hpp>

namespace takt {

/// Implemented by the machine's clock and by the virtual clocks of tests and simulation.
class Clock {
 public:
  virtual ~Clock() = default;
  /// Called from real-time threads: no lock, no allocation, no system call.
  virtual Instant now() noexcept = 0;
};

}  // namespace takt
