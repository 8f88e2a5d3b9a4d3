#include <algorithm>
#include <cstdio>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/host/component_path.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/validate.hpp>

#include "commands.hpp"
#include "load.hpp"
#include "terminal.hpp"

namespace takt::tool {

namespace {

/// One line for the two ports of a service or client.
std::string service_text(const host::Description& component, const model::Port& request) {
  if (!request.name.ends_with(model::kRequestPort)) return {};
  const std::string name = model::name_of_service(request);
  const auto type_of = [](const model::Type& type) {
    const auto inner = std::find_if(type.fields.begin(), type.fields.end(), [](const model::Field& field) {
      return field.scalar == model::Scalar::structure;
    });
    return inner == type.fields.end() ? type.name : inner->type_name;
  };
  const auto reply =
      std::find_if(component.ports.begin(), component.ports.end(),
                   [&](const model::Port& port) { return port.name == name + model::kReplyPort; });
  return fmt::format("  {:<11} {:<16} {} -> {}{}{}\n",
                     request.role == model::Role::client ? "client" : "service", name, type_of(request.type),
                     reply == component.ports.end() ? "?" : type_of(reply->type),
                     request.text.empty() ? "" : "  ", request.text);
}

std::string as_text(const std::string& path, const host::Description& component) {
  std::string text = fmt::format("{}  ({})\n", component.name, path);
  text += fmt::format("  interface   {}\n", component.interface);
  if (!component.hooks.empty()) text += fmt::format("  hooks       {}\n", fmt::join(component.hooks, ", "));
  if (component.interface == "c") text += "  properties  any; initialize() reads them\n";
  if (component.interface == "process")
    text += "  properties  any; the program gets each as an argument NAME=VALUE\n";
  for (const model::Port& port : component.ports) {
    if (port.role != model::Role::plain) {
      text += service_text(component, port);
      continue;
    }
    text += fmt::format("  {:<11} {:<16} {}{}{}\n", to_text(port.direction), port.name, port.type.name,
                        port.text.empty() ? "" : "  ", port.text);
  }
  if (component.interface != "c++") return text;
  text += component.properties.empty() ? "  properties  none\n" : "  properties\n";
  for (const auto& p : component.properties) {
    text += fmt::format("    {:<16} {:<8} {}{}{}{}{}\n", p.name, p.type, p.default_value,
                        p.unit.empty() ? "" : " " + p.unit, p.range.empty() ? "" : "  (" + p.range + ")",
                        p.text.empty() ? "" : "  ", p.text);
  }
  return text;
}

std::string as_json(const host::Description& component) {
  nlohmann::ordered_json properties = nlohmann::ordered_json::array();
  for (const auto& p : component.properties) {
    properties.push_back({{"name", p.name},
                          {"type", p.type},
                          {"default", p.default_value},
                          {"range", p.range},
                          {"unit", p.unit},
                          {"text", p.text}});
  }
  return nlohmann::ordered_json{
             {"name", component.name},
             {"interface", component.interface},
             {"hooks", component.hooks},
             {"properties", properties},
             {"ports", nlohmann::ordered_json::parse(model::ports_json(component.ports))["ports"]}}
             .dump() +
         "\n";
}

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '"')
      result += "&quot;";
    else
      result += c;
  }
  return result;
}

/// The file's stem, as far as a module may be named so.
std::string proposed_name(const std::string& path) {
  std::string name = model::file_stem(path).substr(0, model::kMaxNameLength);
  for (char& c : name) {
    if (!model::is_valid_name(std::string{"_"} + c)) c = '_';
  }
  if (!model::is_valid_name(name)) name = "_" + name.substr(0, model::kMaxNameLength - 1);
  return name;
}

/// A descriptor could not say it, so the component keeps its default.
bool is_unsayable(const host::PropertyDescription& property) {
  const std::string& value = property.default_value;
  return property.type == "double" && (value.ends_with("inf") || value.ends_with("nan"));
}

// What has an event port is offered as sporadic and released by it, a module in the C form that has a
// condition as sporadic, everything else as periodic.
std::string as_xml(const std::string& path, const host::Description& component) {
  const bool thread = component.interface != "process";
  const bool has_event =
      std::any_of(component.ports.begin(), component.ports.end(), [](const model::Port& port) {
        return port.role == model::Role::plain && port.direction == model::Direction::event;
      });
  const bool sporadic = has_event || std::find(component.hooks.begin(), component.hooks.end(), "condition") !=
                                         component.hooks.end();
  std::string text = "<module>\n";
  text += fmt::format("  <name>{}</name>\n", proposed_name(path));
  text +=
      fmt::format("  <filename>{}</filename>\n", escaped(std::filesystem::path{path}.filename().string()));
  text += fmt::format("  <moduletype>{}</moduletype>\n", thread ? "thread" : "process");
  text += fmt::format("  <operationtype>{}</operationtype>\n", sporadic ? "sporadic" : "periodic");
  text += fmt::format("  <{0}>1000000</{0}> <!-- ns -->\n", sporadic ? "deadline" : "period");
  if (has_event) text += "  <dispatch>immediate</dispatch> <!-- connect an event port -->\n";
  text += "  <priority>1</priority> <!-- the lowest value goes first -->\n";
  if (!std::all_of(component.properties.begin(), component.properties.end(), is_unsayable)) {
    text += "  <property>\n";
    for (const auto& p : component.properties) {
      if (is_unsayable(p)) continue;
      text += fmt::format("    <value name=\"{}\">{}</value>\n", escaped(p.name), escaped(p.default_value));
    }
    text += "  </property>\n";
  }
  return text + "</module>\n";
}

}  // namespace

int describe(const DescribeOptions& options) {
  const auto path = host::find_component(options.file, "");
  if (!path) {
    complain(path.problems());
    return 1;
  }
  const auto component = host::describe(*path, options.arguments);
  if (!component) {
    complain(component.problems());
    return 1;
  }
  const std::string text = options.json  ? as_json(*component)
                           : options.xml ? as_xml(*path, *component)
                                         : as_text(*path, *component);
  return print(text) ? 0 : 1;
}

}  // namespace takt::tool
