// A thread module in C++: monitors that other modules are alive.
#include <takt/component.hpp>

#include <array>
#include <cmath>
#include <optional>
#include <string>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "life_sign.hpp"

class Watchdog : public takt::Component {
  takt::InPort<basic::Count> count{*this, "count", {.text = "A counter that another module increments."}};
  takt::InPort<basic::Flag> flag{*this, "flag", {.text = "A flag that another module toggles."}};
  takt::InPort<basic::Number> number{*this, "number", {.text = "A value that arrives or changes."}};
  takt::InPort<basic::Flag> reset{*this, "reset", {.text = "A rising edge clears a latched alarm."}};
  takt::OutPort<basic::Flag> healthy{*this, "healthy", {.text = "True if every connected input is alive."}};
  takt::OutPort<basic::Flag> alarm{
      *this,
      "alarm",
      {.text = "True if an input gave no sign of life in time, or if no input is connected."}};
  takt::Property<double> timeout{
      *this,
      "timeout",
      1,
      {.unit = "s", .min = 1e-6, .max = 1e6, .text = "Maximum time between two signs of life."}};
  takt::Property<std::string> sign{
      *this,
      "sign",
      "change",
      {.text = "What counts as a sign of life: a different value (change) or any sample (sample).",
       .choices = {"change", "sample"}}};
  takt::Property<bool> latching{*this, "latching", false, {.text = "True: an alarm stays on until a reset."}};

  template <class T>
  struct Watched {
    watchdog::LifeSign life;
    std::optional<T> last;
  };
  Watched<std::int64_t> count_;
  Watched<bool> flag_;
  Watched<double> number_;
  bool alarm_ = false;
  common::Releases releases_;
  common::RisingEdge reset_;
  basic::Flag output_;

  takt::Result<void> initialize() override {
    if (auto checked = common::check_period(period()); !checked) return checked;
    return timeout.narrow(common::in_seconds(period()), {}, common::at_period(period()));
  }

  void run(const takt::Cycle& cycle) noexcept override {
    const auto passed = static_cast<std::int64_t>(releases_.step(cycle.number)) * cycle.period.count();
    const bool acknowledge = common::count_rising(reset, reset_) > 0;
    const std::int64_t within = std::llround(timeout * 1e9);
    look(count, count_, passed, within);
    look(flag, flag_, passed, within);
    look(number, number_, passed, within);
    const bool any = count.connected() || flag.connected() || number.connected();
    const bool dead = !any || count_.life.dead() || flag_.life.dead() || number_.life.dead();
    alarm_ = dead || (alarm_ && latching && !acknowledge);
    write(healthy, any && !alarm_ && alive(count, count_) && alive(flag, flag_) && alive(number, number_));
    write(alarm, alarm_);
  }

  template <class Port, class T>
  void look(Port& port, Watched<T>& watched, std::int64_t passed, std::int64_t within) noexcept {
    if (!port.connected()) return;
    bool any = false;
    while (port.read()) {
      const T value = port.value().value();
      if constexpr (std::is_same_v<T, double>) {
        if (!std::isfinite(value)) continue;  // NaN or infinity from a broken sensor is no sign of life
      }
      any = any || sign.value() == "sample" || watched.last != value;
      watched.last = value;
    }
    watched.life.step(any, passed, within);
  }
  template <class Port, class T>
  static bool alive(const Port& port, const Watched<T>& watched) noexcept {
    return !port.connected() || watched.life.alive();
  }
  void write(takt::OutPort<basic::Flag>& port, bool is) noexcept {
    output_.value(is);
    port.write(output_);
  }

  void error(takt::ErrorType) override { write(healthy, false); }
  void destruct() override { write(healthy, false); }
  takt::Result<void> recover() override {
    count_ = {};
    flag_ = {};
    number_ = {};
    releases_.reset();
    return {};
  }
};
TAKT_COMPONENT(Watchdog, "Raises an alarm when an input stops changing or arriving.")
