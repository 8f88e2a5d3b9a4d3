// A thread module in C++: the logic of an emergency stop with two channels. It is not a certified safety
// function.
#include <takt/component.hpp>

#include <cmath>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "two_channel_stop.hpp"

class EmergencyStop : public takt::Component {
  takt::InPort<basic::Flag> channel_a{
      *this, "channel_a", {.text = "First contact. True: the contact is closed and requests no stop."}};
  takt::InPort<basic::Flag> channel_b{
      *this, "channel_b", {.text = "Second contact. True: the contact is closed and requests no stop."}};
  takt::InPort<basic::Flag> reset{
      *this, "reset", {.text = "A rising edge permits running once both channels are closed."}};
  takt::OutPort<basic::Flag> run_permitted{
      *this,
      "run_permitted",
      {.text = "Whether the machine may run; written every cycle. Connect its readers with a deadline.",
       .safe = basic::Flag{}}};
  takt::OutPort<basic::Count> state{
      *this,
      "state",
      {.text = "0: permitted, 1: stopped, 2: waits for a reset, 3: discrepancy, 4: no signal."}};
  takt::Property<double> discrepancy_time{
      *this,
      "discrepancy_time",
      0.1,
      {.unit = "s", .min = 1e-6, .max = 10, .text = "One channel must follow the other within this time."}};
  takt::Property<double> timeout{*this,
                                 "timeout",
                                 0.1,
                                 {.unit = "s",
                                  .min = 1e-6,
                                  .max = 10,
                                  .text = "An input older than this counts as missing and causes a stop."}};

  takt::Property<bool> start_reset{
      *this,
      "start_reset",
      false,
      {.text = "True: after the start, the module needs no reset when both channels first close."}};

  emergency_stop::TwoChannelStop stop_;
  common::Releases releases_;
  basic::Flag permitted_;
  basic::Count state_;

  takt::Result<void> initialize() override {
    if (auto checked = common::check_period(period()); !checked) return checked;
    const double shortest = common::in_seconds(period());
    auto first = discrepancy_time.narrow(shortest, {}, common::at_period(period()));
    auto second = timeout.narrow(shortest, {}, common::at_period(period()));
    return first ? second : first;
  }

  void run(const takt::Cycle& cycle) noexcept override {
    const auto passed = static_cast<std::int64_t>(releases_.step(cycle.number)) * cycle.period.count();
    common::read_newest(channel_a);
    common::read_newest(channel_b);
    common::read_newest(reset);
    stop_.step({.a = channel_a.value().value(),
                .b = channel_b.value().value(),
                .fresh = fresh(channel_a) && fresh(channel_b),
                .reset = reset.value().value(),
                .reset_fresh = fresh(reset),
                .start_reset = start_reset},
               passed, std::llround(discrepancy_time * 1e9));
    tell();
  }

  [[nodiscard]] bool fresh(const takt::InPort<basic::Flag>& port) const noexcept {
    return port.has_value() && port.age().count() <= std::llround(timeout * 1e9);
  }
  void tell() noexcept {
    permitted_.value(stop_.state() == emergency_stop::State::permitted);
    run_permitted.write(permitted_);
    state_.value(static_cast<std::int64_t>(stop_.state()));
    state.write(state_);
    safe_stop(stop_.state() != emergency_stop::State::permitted);
  }

  // Withdraws the permission, so that the machine needs a reset. The module calls this after an error, before
  // it continues after a recovery, and at its end.
  void halt() noexcept {
    stop_.trip();
    tell();
  }
  void error(takt::ErrorType) override { halt(); }
  void destruct() override { halt(); }
  takt::Result<void> recover() override {
    releases_.reset();
    halt();
    return {};
  }
};
TAKT_COMPONENT(EmergencyStop, "Logic of a two-channel emergency stop; not certified.")
