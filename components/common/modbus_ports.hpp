// The ports for the points of a map: a basic::Flag for a bit, a basic::Number for a register. A process
// module creates the ports after it has parsed the map and before it calls initPeriodExe(). The cyclic body
// of the module calls read() and write().
#pragma once

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <string>

#include <takt/process.hpp>

#include <basic.hpp>

#include "modbus_map.hpp"

namespace modbus {

inline std::string description(const Point& point) {
  std::string text = std::string{to_text(point.table)} + " " + std::to_string(point.address);
  if (point.width() == 2) text += " and " + std::to_string(point.address + 1);
  return point.unit.empty() ? text : text + ", in " + point.unit;
}

/// The input port for a point.
class PointInput {
 public:
  explicit PointInput(const Point& point) {
    if (is_bit(point.table))
      flag_ = std::make_unique<takt::InPort<basic::Flag>>(point.name, takt::PortOptions{description(point)});
    else
      number_ =
          std::make_unique<takt::InPort<basic::Number>>(point.name, takt::PortOptions{description(point)});
  }
  /// Reads the newest sample into `value`; a bit is 0 or 1. Returns false if there is no new sample.
  bool read(double& value) noexcept {
    bool news = false;
    while (flag_ ? flag_->read() : number_->read()) news = true;
    if (news) value = flag_ ? (flag_->value().value() ? 1 : 0) : number_->value().value();
    return news;
  }

 private:
  std::unique_ptr<takt::InPort<basic::Flag>> flag_;
  std::unique_ptr<takt::InPort<basic::Number>> number_;
};

/// The output port for a point.
class PointOutput {
 public:
  explicit PointOutput(const Point& point) {
    if (is_bit(point.table))
      flag_ = std::make_unique<takt::OutPort<basic::Flag>>(
          point.name, takt::OutPort<basic::Flag>::Options{.text = description(point)});
    else
      number_ = std::make_unique<takt::OutPort<basic::Number>>(
          point.name, takt::OutPort<basic::Number>::Options{.text = description(point)});
  }
  void write(double value) noexcept {
    if (flag_) {
      basic::Flag flag;
      flag.value(value != 0);
      flag_->write(flag);
    } else {
      basic::Number number;
      number.value(value);
      number_->write(number);
    }
  }

 private:
  std::unique_ptr<takt::OutPort<basic::Flag>> flag_;
  std::unique_ptr<takt::OutPort<basic::Number>> number_;
};

/// Returns the points of the property `map`. If the map has mistakes, prints each on one line of standard
/// error and ends the process with status 1.
inline std::vector<Point> points_or_end(const std::string& text) {
  if (text.empty()) {
    std::fprintf(stderr, "property 'map' is missing; write one point per line, as in 'lamp out coil 0'\n");
    std::exit(1);
  }
  Map map = parse_map(text);
  for (const Mistake& mistake : map.mistakes)
    std::fprintf(stderr, "property 'map', line %u: %s; %s\n", mistake.line, mistake.what.c_str(),
                 mistake.fix.c_str());
  if (!map.mistakes.empty()) std::exit(1);
  return std::move(map.points);
}

}  // namespace modbus
