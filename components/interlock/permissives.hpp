// The mathematics of the component interlock: permits an action while all conditions are true, and keeps the
// number of the first condition that failed. Real-time threads may use everything here.
#pragma once

#include <bit>
#include <cstdint>

namespace interlock {

/// Decides whether an action is permitted. A set of inputs is a bit mask: bit 0 is input 1. The first-out
/// works as in an annunciator of ISA-18.1: it keeps the number of the first input that dropped after all were
/// true, even if other inputs drop or return later.
class Permissives {
 public:
  /// Makes one step. Returns true if the action is permitted. `used` holds the connected inputs, `given` the
  /// inputs that are true. With `latching`, permission returns only on a `reset` while all used inputs are
  /// true.
  bool step(std::uint32_t used, std::uint32_t given, bool latching, bool reset) noexcept {
    const std::uint32_t missing = used & ~given;
    const bool all = used != 0 && missing == 0;
    if (permitted_ && missing != 0) first_out_ = std::countr_zero(missing) + 1;
    if (reset && all) first_out_ = 0;
    tripped_ = latching && (tripped_ || (permitted_ && !all)) && !(reset && all);
    permitted_ = all && !tripped_;
    return permitted_;
  }
  /// Returns the number of the input that dropped first, 1 to 32; 0: none has dropped since the last reset.
  [[nodiscard]] int first_out() const noexcept { return first_out_; }
  [[nodiscard]] bool permitted() const noexcept { return permitted_; }

 private:
  bool permitted_ = false;
  bool tripped_ = false;
  int first_out_ = 0;
};

}  // namespace interlock
