#include "program_properties.hpp"

#include <algorithm>
#include <string_view>
#include <utility>
#include <vector>

#include <takt/component/property.hpp>
#include <takt/core/log_level.hpp>
#include <takt/core/words.hpp>
#include <takt/os/environment.hpp>

namespace takt {

namespace {

// The properties of this program. The constructors of the program's global variables use this struct before
// main() begins.
struct Properties {
  std::vector<PropertyBase*> all;  // in the order of construction
  std::vector<std::pair<std::string, std::string>> given;
  Problems refused;

  // Reads the values of properties from the arguments. An argument such as --mode=fast is not a property.
  Properties() {
    for (const std::string& argument : os::program_arguments()) {
      const auto equals = argument.find('=');
      if (equals != std::string::npos && argument[0] != '-')
        given.emplace_back(argument.substr(0, equals), argument.substr(equals + 1));
    }
  }
};

Properties& properties() {
  static Properties ours;
  return ours;
}

bool has(const std::string& name) {
  return std::any_of(properties().all.begin(), properties().all.end(),
                     [&](const PropertyBase* property) { return property->name() == name; });
}

}  // namespace

std::vector<PropertyBase*> take_loose_properties() { return properties().all; }

namespace detail {

void add_loose_property(PropertyBase& property) {
  Properties& ours = properties();
  ours.all.push_back(&property);
  for (const auto& [name, value] : ours.given) {
    if (name != property.name()) continue;
    if (const auto assigned = property.assign(value); !assigned)
      ours.refused.insert(ours.refused.end(), assigned.problems().begin(), assigned.problems().end());
  }
}

void remove_loose_property(PropertyBase& property) noexcept { std::erase(properties().all, &property); }

}  // namespace detail

Problems check_program_properties() {
  Properties& ours = properties();
  Problems problems = check_declared(ours.all, "this program");
  problems.insert(problems.end(), ours.refused.begin(), ours.refused.end());
  std::vector<std::string_view> names;
  for (const PropertyBase* property : ours.all) names.emplace_back(property->name());
  names.emplace_back(kLogLevelProperty);
  for (const auto& [name, value] : ours.given) {
    if (!ours.all.empty() && !has(name))
      problems.push_back(fail("this program has no property " + in_quotes(name), suggestion(name, names)));
  }
  return problems;
}

std::string program_properties_json() {
  std::string list;
  for (const PropertyBase* property : properties().all) {
    const auto member = [&list](const char* name, const std::string& value) {
      list += in_json(name) + ":" + in_json(value) + ",";
    };
    list += list.empty() ? "{" : ",{";
    member("name", property->name());
    member("type", to_text(property->type()));
    member("default", property->default_text());
    member("range", property->range_text());
    member("min", property->min_text());
    member("max", property->max_text());
    member("unit", property->unit());
    list += in_json("text") + ":" + in_json(property->text()) + "}";
  }
  return "[" + list + "]";
}

std::string in_json(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    constexpr char kDigits[] = "0123456789abcdef";
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      result += {'\\', c};
    else if (code < 0x20)
      result += std::string{"\\u00"} + kDigits[code >> 4] + kDigits[code & 15];
    else
      result += c;
  }
  return result + '"';
}

}  // namespace takt
