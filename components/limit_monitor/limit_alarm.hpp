// An alarm on a value that is beyond its limit. For real-time threads.
#pragma once

#include <cstdint>

namespace limit_monitor {

/// Comes when the value has been beyond the limit for a time without a break, goes when it is back by the
/// hysteresis (ISA-18.2: on-delay and deadband). With `latching` it goes only when it is acknowledged after
/// that.
class LimitAlarm {
 public:
  struct Settings {
    std::int64_t delay_ns = 0;
    double hysteresis = 0;  ///< in the unit of the value, at least 0
    bool latching = false;
  };

  /// `beyond`: how far the value is beyond the limit, below 0 when it is within. Times in nanoseconds.
  bool step(double beyond, const Settings& settings, bool acknowledge, std::int64_t passed_ns) noexcept {
    const bool over = beyond > 0;
    over_ns_ = over && was_over_ ? over_ns_ + passed_ns : 0;
    was_over_ = over;
    if (over && over_ns_ >= settings.delay_ns)
      on_ = true;
    else if (beyond <= -settings.hysteresis)
      on_ = on_ && !over && settings.latching && !acknowledge;
    return on_;
  }
  [[nodiscard]] bool on() const noexcept { return on_; }

 private:
  bool on_ = false;
  bool was_over_ = false;
  std::int64_t over_ns_ = 0;
};

}  // namespace limit_monitor
