#include "arm_model/parameters.hpp"

#include <cmath>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include <nlohmann/json.hpp>

namespace arm_model {

namespace {

constexpr double kPi = std::numbers::pi;

struct Number {
  const char* name;
  double Axis::*value;
  double at_least;
  bool above;  // true: the value must be above at_least; false: it may also equal at_least
};
constexpr double kAny = -1e9;
constexpr Number kNumbers[] = {
    {"a", &Axis::a, kAny, false},           {"alpha", &Axis::alpha, kAny, false},
    {"d", &Axis::d, kAny, false},           {"theta", &Axis::theta, kAny, false},
    {"lower", &Axis::lower, kAny, false},   {"upper", &Axis::upper, kAny, false},
    {"velocity", &Axis::velocity, 0, true}, {"acceleration", &Axis::acceleration, 0, true},
    {"torque", &Axis::torque, 0, true},     {"home", &Axis::home, kAny, false},
    {"mass", &Axis::mass, 0, false},        {"rotor", &Axis::rotor, 0, true},
    {"viscous", &Axis::viscous, 0, false},  {"dry", &Axis::dry, 0, false},
};
struct Triple {
  const char* name;
  std::array<double, 3> Axis::*value;
  double at_least;
};
constexpr Triple kTriples[] = {{"centre", &Axis::centre, kAny}, {"inertia", &Axis::inertia, 0}};

double number(const nlohmann::json& json, const std::string& where, double at_least, bool above) {
  const double value = json.is_number() ? json.get<double>() : std::nan("");
  if (std::isfinite(value) && (above ? value > at_least : value >= at_least)) return value;
  const std::string bound =
      at_least == kAny ? "" : (above ? " above " : " of at least ") + std::to_string(int(at_least));
  throw std::runtime_error(where + ": must be a number" + bound);
}

const nlohmann::json& member(const nlohmann::json& json, const std::string& where, const char* name) {
  const auto found = json.find(name);
  if (found == json.end()) throw std::runtime_error(where + "." + name + ": is missing");
  return *found;
}

Axis axis(const nlohmann::json& json, const std::string& where) {
  if (!json.is_object()) throw std::runtime_error(where + ": must be an object");
  Axis axis;
  for (const Number& n : kNumbers)
    axis.*n.value = number(member(json, where, n.name), where + "." + n.name, n.at_least, n.above);
  for (const Triple& t : kTriples) {
    const nlohmann::json& values = member(json, where, t.name);
    const std::string name = where + "." + t.name;
    if (!values.is_array() || values.size() != 3) throw std::runtime_error(name + ": must be three numbers");
    for (std::size_t i = 0; i < 3; ++i)
      (axis.*t.value)[i] = number(values[i], name + "[" + std::to_string(i) + "]", t.at_least, false);
  }
  for (const auto& item : json.items()) {
    const auto known = [&item](const auto& entry) { return item.key() == entry.name; };
    if (std::none_of(std::begin(kNumbers), std::end(kNumbers), known) &&
        std::none_of(std::begin(kTriples), std::end(kTriples), known))
      throw std::runtime_error(where + "." + item.key() + ": unknown member");
  }
  if (axis.lower >= axis.upper) throw std::runtime_error(where + ".lower: must be below upper");
  if (axis.home < axis.lower || axis.home > axis.upper)
    throw std::runtime_error(where + ".home: must be between lower and upper");
  return axis;
}

}  // namespace

const Parameters& built_in() {
  static const Parameters parameters{{
      {.a = 0.16,
       .alpha = -kPi / 2,
       .d = 0.45,
       .theta = 0,
       .lower = -2.9,
       .upper = 2.9,
       .velocity = 3.0,
       .acceleration = 9,
       .torque = 900,
       .home = 0,
       .mass = 30,
       .centre = {-0.06, 0.1, -0.01},
       .inertia = {0.55, 0.5, 0.6},
       .rotor = 8,
       .viscous = 15,
       .dry = 12},
      {.a = 0.6,
       .alpha = 0,
       .d = 0,
       .theta = -kPi / 2,
       .lower = -1.5,
       .upper = 2.3,
       .velocity = 2.8,
       .acceleration = 9,
       .torque = 1000,
       .home = 0,
       .mass = 22,
       .centre = {-0.33, 0, 0.02},
       .inertia = {0.15, 0.95, 0.95},
       .rotor = 8,
       .viscous = 15,
       .dry = 12},
      {.a = 0.12,
       .alpha = -kPi / 2,
       .d = 0,
       .theta = 0,
       .lower = -3.0,
       .upper = 1.2,
       .velocity = 3.0,
       .acceleration = 11,
       .torque = 600,
       .home = 0,
       .mass = 18,
       .centre = {-0.07, 0.01, 0.08},
       .inertia = {0.25, 0.25, 0.15},
       .rotor = 4,
       .viscous = 9,
       .dry = 8},
      {.a = 0,
       .alpha = kPi / 2,
       .d = 0.64,
       .theta = 0,
       .lower = -3.3,
       .upper = 3.3,
       .velocity = 6.0,
       .acceleration = 24,
       .torque = 150,
       .home = 0,
       .mass = 8,
       .centre = {0, -0.22, 0},
       .inertia = {0.12, 0.03, 0.12},
       .rotor = 1.0,
       .viscous = 3,
       .dry = 3},
      {.a = 0,
       .alpha = -kPi / 2,
       .d = 0,
       .theta = 0,
       .lower = -2.1,
       .upper = 2.1,
       .velocity = 6.0,
       .acceleration = 24,
       .torque = 150,
       .home = kPi / 2,
       .mass = 4,
       .centre = {0, 0, 0.03},
       .inertia = {0.012, 0.012, 0.008},
       .rotor = 1.0,
       .viscous = 3,
       .dry = 3},
      {.a = 0,
       .alpha = 0,
       .d = 0.25,
       .theta = 0,
       .lower = -6.2,
       .upper = 6.2,
       .velocity = 7.5,
       .acceleration = 30,
       .torque = 80,
       .home = 0,
       .mass = 2.5,
       .centre = {0, 0, -0.09},
       .inertia = {0.008, 0.008, 0.004},
       .rotor = 0.5,
       .viscous = 1.5,
       .dry = 1.5},
  }};
  return parameters;
}

std::variant<Parameters, std::string> read(const std::string& file) {
  if (file.empty()) return built_in();
  std::ifstream stream{file};
  if (!stream) return file + ": cannot be read";
  try {
    const nlohmann::json json = nlohmann::json::parse(stream, nullptr, true, true);
    const nlohmann::json* axes = json.is_object() && json.contains("axes") ? &json["axes"] : nullptr;
    if (axes == nullptr || !axes->is_array() || axes->size() != kAxes)
      return file + ": must be an object whose member \"axes\" is a list of six objects";
    Parameters parameters;
    for (std::size_t i = 0; i < kAxes; ++i)
      parameters[i] = axis((*axes)[i], "axes[" + std::to_string(i) + "]");
    return parameters;
  } catch (const std::exception& problem) {
    return file + ": " + problem.what();
  }
}

}  // namespace arm_model
