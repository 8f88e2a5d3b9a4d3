// The mathematics of the component up_down_counter: the counters of IEC 61131-3. Real-time threads may use
// everything here.
#pragma once

#include <cstdint>
#include <limits>

namespace up_down_counter {

/// The counter CTUD. Without the inputs `down` and `load`, the counter is a CTU; without `up` and `reset`, it
/// is a CTD. The value saturates at the limits of 64 bits.
class IecCounter {
 public:
  struct Inputs {
    std::uint32_t up = 0, down = 0;  ///< rising edges since the last step
    bool reset = false;              ///< sets the value to 0; overrides `load`
    bool load = false;               ///< sets the value to the preset; overrides counting
  };

  void step(const Inputs& in, std::int64_t preset) noexcept {
    constexpr std::int64_t kHighest = std::numeric_limits<std::int64_t>::max();
    constexpr std::int64_t kLowest = std::numeric_limits<std::int64_t>::min();
    if (in.reset) {
      value_ = 0;
    } else if (in.load) {
      value_ = preset;
    } else {
      // An `up` edge and a `down` edge between two steps cancel out.
      const std::int64_t change = static_cast<std::int64_t>(in.up) - in.down;
      if (change > 0)
        value_ = value_ > kHighest - change ? kHighest : value_ + change;
      else
        value_ = value_ < kLowest - change ? kLowest : value_ + change;
    }
  }
  [[nodiscard]] std::int64_t value() const noexcept { return value_; }                      ///< CV
  [[nodiscard]] bool full(std::int64_t preset) const noexcept { return value_ >= preset; }  ///< QU
  [[nodiscard]] bool empty() const noexcept { return value_ <= 0; }                         ///< QD

 private:
  std::int64_t value_ = 0;
};

}  // namespace up_down_counter
