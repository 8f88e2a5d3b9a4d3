// A thread module in C++: converts samples from one period to another.
#include <takt/component.hpp>

#include <cmath>
#include <string>

#include <basic.hpp>

#include "rate_converter.hpp"

class Resampler : public takt::Component {
  takt::InPort<basic::Number> in{
      *this,
      "in",
      {.text = "Samples of any period; connect it as a queue if the module must see every sample."}};
  takt::OutPort<basic::Number> out{*this, "out", {.text = "One sample per cycle, in the unit of the input."}};
  takt::Property<std::string> method{*this,
                                     "method",
                                     "hold",
                                     {.text = "Method that computes an output from the input samples.",
                                      .choices = {"hold", "linear", "average"}}};

  resampler::RateConverter converter_;
  basic::Number output_;

  [[nodiscard]] resampler::Method chosen() const noexcept {
    if (method.value() == "linear") return resampler::Method::linear;
    return method.value() == "average" ? resampler::Method::average : resampler::Method::hold;
  }

  void run(const takt::Cycle& cycle) noexcept override {
    const std::int64_t now = takt::to_ns(cycle.start);
    while (in.read()) {
      if (!std::isfinite(in.value().value())) {
        fail("the input is not a finite number");
        return;
      }
      converter_.add(in.value().value(), now - in.age().count());
    }
    if (!converter_.begun()) return;
    output_.value(converter_.output(chosen(), now));
    out.write(output_);
  }

  takt::Result<void> recover() override {
    converter_.reset();
    return {};
  }
};
TAKT_COMPONENT(Resampler, "Converts samples from one period to another.")
