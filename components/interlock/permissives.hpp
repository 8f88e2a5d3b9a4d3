// Conditions that must all hold, and which one failed first. For real-time threads.
#pragma once

#include <bit>
#include <cstdint>

namespace interlock {

/// Sets of inputs are words: bit 0 is input 1. First-out as an annunciator of ISA-18.1 has it: of what
/// dropped after all was well, the first is kept, whatever drops or comes back after it.
class Permissives {
 public:
  /// `used`: those that count; `given`: those that hold now. With `latching`, permission comes back only by
  /// `reset`, and that only while all hold. Whether it is permitted.
  bool step(std::uint32_t used, std::uint32_t given, bool latching, bool reset) noexcept {
    const std::uint32_t missing = used & ~given;
    const bool all = used != 0 && missing == 0;
    if (permitted_ && missing != 0) first_out_ = std::countr_zero(missing) + 1;
    if (reset && all) first_out_ = 0;
    tripped_ = latching && (tripped_ || (permitted_ && !all)) && !(reset && all);
    permitted_ = all && !tripped_;
    return permitted_;
  }
  /// 1 to 32; 0: none since the last reset.
  [[nodiscard]] int first_out() const noexcept { return first_out_; }
  [[nodiscard]] bool permitted() const noexcept { return permitted_; }

 private:
  bool permitted_ = false;
  bool tripped_ = false;
  int first_out_ = 0;
};

}  // namespace interlock
