// A periodic thread module: called by the scheduler every period.
#include <takt/component.hpp>

#include <@name@_types.hpp>

class @Name@ : public takt::Component {
  takt::InPort<@name@_types::Sample> in{*this, "in", {.text = "What is multiplied."}};
  takt::OutPort<@name@_types::Sample> out{*this, "out", {.text = "The same, times the gain."}};
  takt::Property<double> gain{*this, "gain", 2, {.min = -1000, .max = 1000, .text = "What it is multiplied with."}};

  @name@_types::Sample result_;

  // Here one may allocate, open and fail: return takt::fail("what is wrong", "what would be right");
  takt::Result<void> initialize() override { return {}; }

  // On the real-time thread: no lock, no allocation, no system call, no log.
  void run(const takt::Cycle&) noexcept override {
    if (!in.read()) return;  // nothing has come since the last run()
    result_.value(gain * in.value().value());
    out.write(result_);
  }
};
TAKT_COMPONENT(@Name@, "Multiplies what comes in.")
