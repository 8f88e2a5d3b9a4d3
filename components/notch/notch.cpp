// A thread module in C++: a notch filter that removes one frequency from a signal.
#include <takt/component.hpp>

#include <cmath>

#include <basic.hpp>

#include "../common/edges.hpp"
#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "notch_filter.hpp"

class Notch : public takt::Component {
  takt::InPort<basic::Number> in{*this, "in", {.text = "Signal to filter, in any unit."}};
  takt::OutPort<basic::Number> out{*this, "out", {.text = "Filtered signal, in the unit of the input."}};
  takt::Property<double> frequency{
      *this, "frequency", 50, {.unit = "Hz", .min = 1e-9, .text = "The frequency to remove."}};
  takt::Property<double> width{*this,
                               "width",
                               10,
                               {.unit = "Hz",
                                .min = 1e-9,
                                .text = "Distance between the two frequencies at which the gain is -3 dB."}};

  notch::NotchFilter filter_;
  common::Releases releases_;
  double frequency_ = 0;
  double width_ = 0;
  basic::Number output_;

  takt::Result<void> initialize() override {
    if (auto checked = common::check_period(period()); !checked) return checked;
    const double rate = 1 / common::in_seconds(period());
    const std::string why = common::at_period(period());
    const double lowest = common::rounded(notch::kLowest * rate);
    const double highest = common::rounded(notch::kHighest * rate);
    auto first = frequency.narrow(lowest, highest, why);
    auto second = width.narrow(lowest, highest, why);
    return first ? second : first;
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
    if (frequency != frequency_ || width != width_) {
      frequency_ = frequency;
      width_ = width;
      filter_.design(frequency_, width_, cycle.seconds());
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
TAKT_COMPONENT(Notch, "Removes one frequency from a signal.")
