// A thread module in C++: raises an alarm when a value is beyond its limits.
#include <takt/component.hpp>

#include <cmath>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "limit_alarm.hpp"

class LimitMonitor : public takt::Component {
  takt::InPort<basic::Number> value{*this, "value", {.text = "The monitored value, in any unit."}};
  takt::InPort<basic::Flag> reset{*this, "reset", {.text = "A rising edge clears latched alarms."}};
  takt::OutPort<basic::Flag> high_alarm{*this, "high_alarm", {.text = "The alarm of the high limit is on."}};
  takt::OutPort<basic::Flag> low_alarm{*this, "low_alarm", {.text = "The alarm of the low limit is on."}};
  takt::OutPort<basic::Flag> ok{*this, "ok", {.text = "The value is finite and no alarm is on."}};
  takt::Property<double> high{
      *this, "high", 1e300, {.text = "High limit, in the unit of the value; above low."}};
  takt::Property<double> low{
      *this, "low", -1e300, {.text = "Low limit, in the unit of the value; below high."}};
  takt::Property<double> hysteresis{
      *this,
      "hysteresis",
      0,
      {.min = 0, .max = 1e300, .text = "An alarm ends when the value is this far within its limit."}};
  takt::Property<double> delay{
      *this,
      "delay",
      0,
      {.unit = "s",
       .min = 0,
       .max = 1e6,
       .text = "How long the value must be beyond its limit before the alarm starts."}};
  takt::Property<bool> latching{*this, "latching", false, {.text = "True: an alarm stays on until a reset."}};

  limit_monitor::LimitAlarm above_;
  limit_monitor::LimitAlarm below_;
  bool was_not_finite_ = false;
  double high_ = 0, low_ = 0, hysteresis_ = 0;
  common::Releases releases_;
  common::RisingEdge reset_;
  basic::Flag flag_;

  [[nodiscard]] bool limits_are_valid() const noexcept { return low < high && hysteresis < high - low; }

  takt::Result<void> initialize() override {
    if (auto checked = common::check_period(period()); !checked) return checked;
    if (!limits_are_valid()) {
      return takt::fail(
          "low is not below high, or hysteresis is not below high - low, so an alarm could never end",
          "set low < high and hysteresis < high - low");
    }
    return {};
  }

  void run(const takt::Cycle& cycle) noexcept override {
    const auto passed = static_cast<std::int64_t>(releases_.step(cycle.number)) * cycle.period.count();
    const bool acknowledge = common::count_rising(reset, reset_) > 0;
    common::read_newest(value);
    // An operator sets the two limits one after the other. In between, they may be inconsistent; then the
    // previous limits stay in effect.
    if (limits_are_valid()) {
      high_ = high;
      low_ = low;
      hysteresis_ = hysteresis;
    }
    const bool number = value.has_value() && std::isfinite(value.value().value());
    if (number) {
      const limit_monitor::LimitAlarm::Settings settings{
          .delay_ns = std::llround(delay * 1e9), .hysteresis = hysteresis_, .latching = latching};
      above_.step(value.value().value() - high_, settings, acknowledge, passed);
      below_.step(low_ - value.value().value(), settings, acknowledge, passed);
      if (acknowledge || !latching) was_not_finite_ = false;
    } else {
      was_not_finite_ = value.has_value();
    }
    write(high_alarm, above_.on());
    write(low_alarm, below_.on());
    write(ok, number && !above_.on() && !below_.on() && !was_not_finite_);
  }

  void write(takt::OutPort<basic::Flag>& port, bool is) noexcept {
    flag_.value(is);
    port.write(flag_);
  }

  void error(takt::ErrorType) override { write(ok, false); }
  void destruct() override { write(ok, false); }
  takt::Result<void> recover() override {
    releases_.reset();
    return {};
  }
};
TAKT_COMPONENT(LimitMonitor, "Raises an alarm when a value is beyond its limits.")
