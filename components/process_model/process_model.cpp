// A thread module in C++: simulates a first-order process with dead time, on which to test a controller.
#include <takt/component.hpp>

#include <cmath>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "first_order.hpp"

class ProcessModel : public takt::Component {
  takt::InPort<basic::Number> in{*this, "in", {.text = "Output of the actuator; 0 before the first sample."}};
  takt::OutPort<basic::Number> out{*this, "out", {.text = "Value that a sensor would measure."}};
  takt::Property<double> gain{*this, "gain", 1, {.text = "Ratio of output to input in the steady state."}};
  takt::Property<double> time_constant{
      *this,
      "time_constant",
      1,
      {.unit = "s", .min = 1e-6, .max = 1e6, .text = "T: time until the output has made 63 % of a step."}};
  takt::Property<double> dead_time{
      *this,
      "dead_time",
      0,
      {.unit = "s", .min = 0, .text = "Delay of the input; rounded to whole periods."}};

  process_model::FirstOrder process_;
  common::Releases releases_;
  basic::Number output_;

  takt::Result<void> initialize() override {
    if (auto checked = common::check_period(period()); !checked) return checked;
    return dead_time.narrow({}, process_model::FirstOrder::kMostDelay * common::in_seconds(period()),
                            common::at_period(period()));
  }

  void run(const takt::Cycle& cycle) noexcept override {
    const std::uint64_t passed = releases_.step(cycle.number);
    common::read_newest(in);
    if (!std::isfinite(in.value().value())) {
      fail("the input is not a finite number");
      return;
    }
    const auto delay = static_cast<std::size_t>(std::lround(dead_time / cycle.seconds()));
    for (std::uint64_t i = common::steps_for(passed); i > 0; --i)
      process_.step(in.value().value(), gain, time_constant, delay, cycle.seconds());
    output_.value(process_.output());
    out.write(output_);
  }
};
TAKT_COMPONENT(ProcessModel, "Simulates a first-order process with dead time.")
