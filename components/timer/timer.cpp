// A thread module in C++: the timers of IEC 61131-3.
#include <takt/component.hpp>

#include <cmath>
#include <string>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "iec_timer.hpp"

class Timer : public takt::Component {
  takt::InPort<basic::Flag> in{*this, "in", {.text = "IN: starts the timer; false before the first sample."}};
  takt::OutPort<basic::Flag> q{*this, "q", {.text = "Q."}};
  takt::OutPort<basic::Number> et{*this, "et", {.text = "ET: the elapsed time, in s."}};
  takt::Property<std::string> kind{
      *this,
      "kind",
      "TON",
      {.text = "On-delay (TON), off-delay (TOF) or pulse (TP).", .choices = {"TON", "TOF", "TP"}}};
  takt::Property<double> time{
      *this,
      "time",
      1,
      {.unit = "s",
       .min = 0,
       .max = 1e8,
       .text = "PT: delay or length of the pulse; a new value also applies to a running timer."}};

  timer::IecTimer timer_;
  timer::Kind kind_ = timer::Kind::on_delay;
  common::Releases releases_;
  basic::Flag q_;
  basic::Number et_;

  takt::Result<void> initialize() override { return common::check_period(period()); }

  void run(const takt::Cycle& cycle) noexcept override {
    const auto passed = static_cast<std::int64_t>(releases_.step(cycle.number)) * cycle.period.count();
    common::read_newest(in);
    const timer::Kind chosen = kind.value() == "TON"   ? timer::Kind::on_delay
                               : kind.value() == "TOF" ? timer::Kind::off_delay
                                                       : timer::Kind::pulse;
    if (chosen != kind_) timer_.reset();
    kind_ = chosen;
    q_.value(timer_.step(kind_, in.value().value(), passed, std::llround(time * 1e9)));
    q.write(q_);
    et_.value(static_cast<double>(timer_.elapsed_ns()) * 1e-9);
    et.write(et_);
  }

  takt::Result<void> recover() override {
    timer_.reset();
    releases_.reset();
    return {};
  }
};
TAKT_COMPONENT(Timer, "On-delay, off-delay and pulse timer.")
