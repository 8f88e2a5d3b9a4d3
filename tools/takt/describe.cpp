#include <cstdio>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/host/component_path.hpp>
#include <takt/host/inspect.hpp>

#include "commands.hpp"
#include "load.hpp"
#include "terminal.hpp"

namespace takt::tool {

namespace {

std::string as_text(const std::string& path, const host::Description& component) {
  std::string text = fmt::format("{}  ({})\n", component.name, path);
  text += fmt::format("  interface   {}\n", component.interface);
  if (!component.hooks.empty()) text += fmt::format("  hooks       {}\n", fmt::join(component.hooks, ", "));
  if (component.interface == "c") text += "  properties  any; initialize() reads them\n";
  if (component.interface == "process") text += "  properties  any; the program gets each as an argument NAME=VALUE\n";
  if (component.interface != "c++") return text;
  text += component.properties.empty() ? "  properties  none\n" : "  properties\n";
  for (const auto& p : component.properties) {
    text += fmt::format("    {:<16} {:<8} {}{}{}{}{}\n", p.name, p.type, p.default_value, p.unit.empty() ? "" : " " + p.unit,
                        p.range.empty() ? "" : "  (" + p.range + ")", p.text.empty() ? "" : "  ", p.text);
  }
  return text;
}

std::string as_json(const host::Description& component) {
  nlohmann::ordered_json properties = nlohmann::ordered_json::array();
  for (const auto& p : component.properties) {
    properties.push_back({{"name", p.name}, {"type", p.type}, {"default", p.default_value}, {"range", p.range},
                          {"unit", p.unit}, {"text", p.text}});
  }
  return nlohmann::ordered_json{{"name", component.name}, {"interface", component.interface}, {"hooks", component.hooks},
                                {"properties", properties}}.dump() + "\n";
}

}  // namespace

int describe(const DescribeOptions& options) {
  const auto path = host::find_component(options.file, "");
  if (!path) {
    complain(path.problems());
    return 1;
  }
  const auto component = host::describe(*path);
  if (!component) {
    complain(component.problems());
    return 1;
  }
  const std::string text = options.json ? as_json(*component) : as_text(*path, *component);
  return print(text) ? 0 : 1;
}

}  // namespace takt::tool
