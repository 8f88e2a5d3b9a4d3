// A thread module in C++: a PID controller in the ISA standard form.
#include <takt/component.hpp>

#include <cmath>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "pid_loop.hpp"

class Pid : public takt::Component {
  takt::InPort<basic::Number> setpoint_in{*this, "setpoint", {.text = "Set point, in the unit of measured."}};
  takt::InPort<basic::Number> measured{*this, "measured", {.text = "The measured value to control."}};
  takt::InPort<basic::Flag> manual{*this, "manual", {.text = "True: the output is manual_value."}};
  takt::InPort<basic::Number> manual_value{
      *this,
      "manual_value",
      {.text = "Output in manual mode; until the first sample, manual mode keeps the last output."}};
  takt::OutPort<basic::Number> output{*this, "output", {.text = "Command for the actuator."}};

  takt::Property<double> setpoint{
      *this, "setpoint", 0, {.text = "Set point if the port setpoint is not connected."}};
  takt::Property<double> gain{*this, "gain", 1, {.text = "Output per unit of measured."}};
  takt::Property<double> integral_time{
      *this, "integral_time", 0, {.unit = "s", .min = 0, .max = 1e6, .text = "Ti; 0: no integral action."}};
  takt::Property<double> derivative_time{
      *this, "derivative_time", 0, {.unit = "s", .min = 0, .max = 1e6, .text = "Td; 0: no derivative."}};
  takt::Property<double> derivative_filter{
      *this,
      "derivative_filter",
      10,
      {.min = 1, .max = 100, .text = "N: the time constant of the derivative's filter is Td / N."}};
  takt::Property<double> setpoint_weight{
      *this,
      "setpoint_weight",
      1,
      {.min = 0, .max = 1, .text = "b: fraction of a set point step that acts at once."}};
  takt::Property<double> tracking_time{
      *this,
      "tracking_time",
      0,
      {.unit = "s",
       .min = 0,
       .max = 1e6,
       .text = "Tt, time constant of the anti-windup; 0: sqrt(Ti Td), or Ti if Td is 0."}};
  takt::Property<double> output_min{
      *this, "output_min", -1, {.text = "Lower limit of the output; below output_max."}};
  takt::Property<double> output_max{
      *this, "output_max", 1, {.text = "Upper limit of the output; above output_min."}};

  takt::Saved<double> kept_{*this, 1};  // the last output
  pid::PidLoop loop_;
  common::Releases releases_;
  basic::Number output_;

  [[nodiscard]] pid::Tuning tuning() const noexcept {
    return {.gain = gain,
            .integral_time = integral_time,
            .derivative_time = derivative_time,
            .derivative_filter = derivative_filter,
            .setpoint_weight = setpoint_weight,
            .tracking_time = tracking_time,
            .low = output_min,
            .high = output_max};
  }
  /// Returns the inconsistency between the values, or null if there is none.
  static const char* inconsistency_in(const pid::Tuning& tuning, double dt) noexcept {
    if (!(tuning.low < tuning.high)) return "output_min is not below output_max";
    if (tuning.integral_time > 0 && tuning.integral_time < dt)
      return "integral_time is shorter than the period";
    return nullptr;
  }

  takt::Result<void> initialize() override {
    if (auto checked = common::check_period(period()); !checked) return checked;
    const double dt = common::in_seconds(period());
    if (const char* what = inconsistency_in(tuning(), dt); what != nullptr) {
      return takt::fail(
          what, "set output_min < output_max, and integral_time to 0 (none) or to at least the period, " +
                    takt::to_text(period()));
    }
    return {};
  }

  takt::Result<void> start() override {
    if (kept_.restored()) loop_.reset(*kept_);
    return {};
  }

  void run(const takt::Cycle& cycle) noexcept override {
    const double dt = cycle.seconds() * static_cast<double>(releases_.step(cycle.number));
    common::read_newest(setpoint_in);
    common::read_newest(measured);
    common::read_newest(manual);
    common::read_newest(manual_value);
    if (!measured.has_value() || (setpoint_in.connected() && !setpoint_in.has_value())) return;
    const double wanted = setpoint_in.connected() ? setpoint_in.value().value() : setpoint.value();
    const double is = measured.value().value();
    const double by_hand = manual_value.has_value() ? manual_value.value().value() : loop_.output();
    if (!std::isfinite(wanted) || !std::isfinite(is) || !std::isfinite(by_hand)) {
      fail("an input is not a finite number");
      return;
    }
    // An operator sets the values one after the other. In between, they may be inconsistent; then the
    // previous values stay in effect.
    const pid::Tuning wanted_tuning = tuning();
    if (inconsistency_in(wanted_tuning, cycle.seconds()) == nullptr) loop_.tune(wanted_tuning);
    output_.value(manual.value().value() ? loop_.manual(wanted, is, by_hand, dt)
                                         : loop_.automatic(wanted, is, dt));
    output.write(output_);
    *kept_ = loop_.output();
  }

  takt::Result<void> recover() override {
    loop_.reset(loop_.output());
    releases_.reset();
    return {};
  }
};
TAKT_COMPONENT(Pid, "PID controller with anti-windup and bumpless transfer.")
