// A thread module in C++: generates test signals.
#include <takt/component.hpp>

#include <string>

#include <basic.hpp>

#include "../common/periodic.hpp"
#include "../common/releases.hpp"
#include "waveform.hpp"

class SignalGenerator : public takt::Component {
  takt::OutPort<basic::Number> out{
      *this, "out", {.text = "Offset + amplitude times the value of the shape (-1 to 1)."}};
  takt::OutPort<basic::Flag> flag{*this, "flag", {.text = "True in the first half of each signal period."}};
  takt::OutPort<basic::Count> count{*this, "count", {.text = "Number of cycles that the module has run."}};
  takt::Property<std::string> shape{*this,
                                    "shape",
                                    "sine",
                                    {.text = "Shape of the signal; with constant, the output is the offset.",
                                     .choices = {"sine", "square", "triangle", "sawtooth", "constant"}}};
  takt::Property<double> frequency{
      *this,
      "frequency",
      1,
      {.unit = "Hz", .min = 0, .text = "Frequency of the signal; at most half the sampling rate."}};
  takt::Property<double> amplitude{
      *this, "amplitude", 1, {.text = "Distance from the middle of the signal to its peak."}};
  takt::Property<double> offset{*this, "offset", 0, {.text = "Value in the middle of the signal's range."}};

  signal_generator::Phase phase_;
  common::Releases releases_;
  basic::Number out_;
  basic::Flag flag_;
  basic::Count count_;

  takt::Result<void> initialize() override {
    if (auto checked = common::check_period(period()); !checked) return checked;
    return frequency.narrow({}, common::rounded(0.5 / common::in_seconds(period())),
                            common::at_period(period()));
  }

  [[nodiscard]] signal_generator::Shape chosen() const noexcept {
    using signal_generator::Shape;
    if (shape.value() == "sine") return Shape::sine;
    if (shape.value() == "square") return Shape::square;
    if (shape.value() == "triangle") return Shape::triangle;
    return shape.value() == "sawtooth" ? Shape::sawtooth : Shape::constant;
  }

  void run(const takt::Cycle& cycle) noexcept override {
    // First advance the phase by the missed releases, then by this one.
    const auto missed = static_cast<double>(releases_.step(cycle.number) - 1);
    phase_.step(frequency, missed * cycle.seconds());
    const double phase = phase_.step(frequency, cycle.seconds());
    out_.value(offset + amplitude * signal_generator::shape_at(chosen(), phase));
    out.write(out_);
    flag_.value(phase < 0.5);
    flag.write(flag_);
    count_.value(count_.value() + 1);
    count.write(count_);
  }
};
TAKT_COMPONENT(SignalGenerator, "Generates test signals: sine, square, triangle, sawtooth or constant.")
