#include <takt/host/description.hpp>

#include <nlohmann/json.hpp>

#include <takt/model/json.hpp>

namespace takt::host {

using json = nlohmann::ordered_json;

std::string to_json(const Description& description) {
  // Returns a bound as a number; null if there is no bound.
  const auto bound = [](const std::string& text) { return text.empty() ? json{} : model::parse_json(text); };
  json properties = json::array();
  for (const PropertyDescription& p : description.properties) {
    properties.push_back({{"name", p.name},
                          {"type", p.type},
                          {"default", p.default_value},
                          {"range", p.range},
                          {"min", bound(p.min)},
                          {"max", bound(p.max)},
                          {"unit", p.unit},
                          {"text", p.text}});
  }
  json saved;
  if (description.saved)
    saved = {{"version", description.saved->version}, {"bytes", description.saved->bytes}};
  return model::json_text({{"name", description.name},
                           {"text", description.text},
                           {"version", description.version},
                           {"interface", description.interface},
                           {"operation", description.operation},
                           {"hooks", description.hooks},
                           {"properties", properties},
                           {"ports", model::parse_json(model::ports_json(description.ports))["ports"]},
                           {"saved", saved}});
}

Result<std::vector<PropertyDescription>> parse_properties(const std::string& text) {
  const json list = model::parse_json(text);
  if (!list.is_array()) return fail("expected a list of properties");
  std::vector<PropertyDescription> properties;
  for (const json& each : list) {
    const auto member = [&each](const char* name) {
      return each.is_object() && each.contains(name) && each[name].is_string() ? each[name].get<std::string>()
                                                                               : "";
    };
    if (member("name").empty()) return fail("a property has no name");
    properties.push_back({member("name"), member("type"), member("default"), member("range"), member("min"),
                          member("max"), member("unit"), member("text")});
  }
  return properties;
}

}  // namespace takt::host
