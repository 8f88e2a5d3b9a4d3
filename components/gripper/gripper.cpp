// A thread module in C++: simulates a gripper with two fingers.
#include <takt/component.hpp>

#include <sstream>
#include <string>

#include <basic.hpp>

#include "grip.hpp"

class Gripper : public takt::Component {
  takt::InPort<basic::Flag> close{*this, "close", {.text = "True closes the fingers; false opens them."}};
  takt::InPort<basic::Flag> part_present{
      *this, "part_present", {.text = "A part is between the fingers. Always true if not connected."}};
  takt::OutPort<basic::Flag> holding{*this, "holding", {.text = "The fingers are closed on a part."}};
  takt::OutPort<basic::Number> width{*this, "width", {.text = "Distance between the fingers, m."}};
  takt::Property<double> stroke{
      *this,
      "stroke",
      0.08,
      {.unit = "m", .min = 0.001, .max = 1, .text = "Distance between the open fingers."}};
  takt::Property<double> speed{
      *this, "speed", 0.1, {.unit = "m/s", .min = 0.001, .max = 5, .text = "Rate of change of the width."}};
  takt::Property<double> part_width{
      *this,
      "part_width",
      0.04,
      {.unit = "m", .min = 0, .max = 1, .text = "Width of the parts; at most the stroke."}};

  gripper::Fingers fingers_;
  basic::Flag holding_;
  basic::Number width_;

  takt::Result<void> start() override {
    if (part_width > stroke) {
      const auto text = [](double metres) {
        std::ostringstream out;
        out << metres << " m";
        return out.str();
      };
      return takt::fail(
          "a part of " + text(part_width) + " does not fit between fingers that open " + text(stroke),
          "increase stroke or reduce part_width");
    }
    fingers_.stroke = stroke;
    fingers_.reset();
    return {};
  }

  void run(const takt::Cycle& cycle) noexcept override {
    fingers_.stroke = stroke;
    fingers_.speed = speed;
    fingers_.part_width = part_width;
    close.read();
    part_present.read();
    // A connected input reads false before its first sample: `close` then opens the fingers, and no part is
    // present.
    const bool there = !part_present.connected() || part_present.value().value();
    fingers_.step(close.value().value(), there, cycle.seconds());
    holding_.value(fingers_.holding);
    holding.write(holding_);
    width_.value(fingers_.width);
    width.write(width_);
  }
};
TAKT_COMPONENT(Gripper, "Simulates a gripper with two fingers.")
