// A periodic thread module: the scheduler calls run() in every period.
#include <takt/component.hpp>

#include <@name@_types.hpp>

class @Name@ : public takt::Component {
  takt::InPort<@name@_types::Sample> in{*this, "in", {.text = "The input."}};
  takt::OutPort<@name@_types::Sample> out{*this, "out", {.text = "The input times the gain."}};
  takt::Property<double> gain{*this, "gain", 2, {.min = -1000, .max = 1000, .text = "The factor."}};

  @name@_types::Sample result_;

  // initialize() may allocate memory and open files. To fail, return takt::fail("what is wrong", "what to
  // do").
  takt::Result<void> initialize() override { return {}; }

  // run() runs on the real-time thread: it must not lock, allocate memory, make system calls or print. To log,
  // use log().
  void run(const takt::Cycle&) noexcept override {
    if (!in.read()) return;  // no new sample since the last run()
    result_.value(gain * in.value().value());
    out.write(result_);
  }
};
TAKT_COMPONENT(@Name@, "Multiplies the input by a gain.")
