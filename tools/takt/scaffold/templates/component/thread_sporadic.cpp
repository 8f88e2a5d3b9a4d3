// A sporadic thread module: the scheduler calls run() when an event has arrived.
#include <takt/component.hpp>

#include <@name@_types.hpp>

class @Name@ : public takt::Component {
  // The scheduler calls run() while the port has an unread event. For another condition, override bool
  // condition().
  takt::EventPort<@name@_types::Sample> in{*this, "in", {.text = "The input."}};
  takt::OutPort<@name@_types::Sample> out{*this, "out", {.text = "The input times the gain."}};
  takt::Property<double> gain{*this, "gain", 2, {.min = -1000, .max = 1000, .text = "The factor."}};

  @name@_types::Sample result_;

  // initialize() may allocate memory and open files. To fail, return takt::fail("what is wrong", "what to
  // do").
  takt::Result<void> initialize() override { return {}; }

  // run() runs on the real-time thread: it must not lock, allocate memory, make system calls or print. To log,
  // use log().
  void run(const takt::Cycle&) noexcept override {
    while (in.read()) {
      result_.value(gain * in.value().value());
      out.write(result_);
    }
  }
};
TAKT_COMPONENT(@Name@, "Multiplies each input by a gain.")
