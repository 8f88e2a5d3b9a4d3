// The mathematics of the component limit_monitor: an alarm for a value beyond its limit. Real-time threads
// may use everything here.
#pragma once

#include <cstdint>

namespace limit_monitor {

/// Decides when an alarm is on. The alarm starts when the value has been beyond the limit for the delay
/// without interruption. The alarm ends when the value is inside the limit by at least the hysteresis
/// (ISA-18.2: on-delay and deadband). With `latching`, it also needs an acknowledgement to end.
class LimitAlarm {
 public:
  struct Settings {
    std::int64_t delay_ns = 0;
    double hysteresis = 0;  ///< hysteresis in the unit of the value, at least 0
    bool latching = false;
  };

  /// Makes one step. Returns true if the alarm is on. `beyond`: distance of the value beyond the limit,
  /// negative inside it. `passed_ns`: time since the last step.
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
