// A thread module in C++: a Butterworth low-pass.
#include <takt/component.hpp>

#include <cmath>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "low_pass_filter.hpp"

class LowPass : public takt::Component {
  takt::InPort<basic::Number> in{*this, "in", {.text = "Signal to filter, in any unit."}};
  takt::OutPort<basic::Number> out{*this, "out", {.text = "Filtered signal, in the unit of the input."}};
  takt::Property<double> cutoff{
      *this, "cutoff", 10, {.unit = "Hz", .min = 1e-9, .text = "Frequency at which half the power passes."}};
  takt::Property<std::int32_t> order{
      *this,
      "order",
      2,
      {.min = 1, .max = 2, .text = "Order of the filter; each order adds 20 dB per decade."}};

  low_pass::LowPassFilter filter_;
  common::Releases releases_;
  double cutoff_ = 0;
  std::int32_t order_ = 0;
  basic::Number output_;

  takt::Result<void> initialize() override {
    if (auto checked = common::check_period(period()); !checked) return checked;
    const double rate = 1 / common::in_seconds(period());
    return cutoff.narrow(common::rounded(low_pass::kLowest * rate),
                         common::rounded(low_pass::kHighest * rate), common::at_period(period()));
  }

  void run(const takt::Cycle& cycle) noexcept override {
    const std::uint64_t passed = releases_.step(cycle.number);
    common::read_newest(in);
    if (!in.has_value()) return;
    const double value = in.value().value();
    if (!std::isfinite(value)) {
      fail("the input is not a finite number");
      return;
    }
    if (cutoff != cutoff_ || order != order_) {
      cutoff_ = cutoff;
      order_ = order;
      filter_.design(cutoff_, cycle.seconds(), order_);
    }
    double result = 0;
    for (std::uint64_t i = common::steps_for(passed); i > 0; --i) result = filter_.step(value);
    output_.value(result);
    out.write(output_);
  }

  takt::Result<void> recover() override {
    filter_.reset();
    releases_.reset();
    return {};
  }
};
TAKT_COMPONENT(LowPass, "Low-pass filter of first or second order.")
