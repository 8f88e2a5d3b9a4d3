#include "reports/describe_report.hpp"

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <takt/core/control_character.hpp>
#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/model/safe.hpp>
#include <takt/model/validate.hpp>

#include "reports/page.hpp"

namespace takt::tool {

namespace {

constexpr std::size_t kWidth = 100;

/// The lines of a text that is wrapped between words to at most `width` characters.
Page::Words wrapped_words(const std::string& text, std::size_t width) {
  Page::Words lines{""};
  std::istringstream words{text};
  for (std::string word; words >> word;) {
    std::string& line = lines.back();
    if (!line.empty() && line.size() + 1 + word.size() > width)
      lines.push_back(word);
    else
      line += (line.empty() ? "" : " ") + word;
  }
  return lines;
}

/// Adds rows with aligned columns. The last column is a sentence, which is wrapped. If the other columns
/// leave too little width for the sentence, the sentence goes on the next line.
void rows(Page& page, std::size_t indent, std::vector<Page::Words> all) {
  for (Page::Words& row : all) {
    for (std::string& cell : row) cell = on_one_line(cell);
  }
  constexpr std::size_t kLittle = 30;
  std::vector<Page::Words> columns;
  for (const Page::Words& row : all) columns.emplace_back(row.begin(), row.end() - 1);
  const std::vector<std::size_t> widths = Page::widths_of(columns);
  std::size_t begin = indent;
  for (const std::size_t width : widths) begin += width == 0 ? 0 : width + 2;
  const bool beside = begin + kLittle <= kWidth;
  for (const Page::Words& row : all) {
    std::string line;
    for (std::size_t i = 0; i + 1 < row.size(); ++i) {
      if (widths[i] != 0) line += fmt::format("{:<{}}", row[i], widths[i] + 2);
    }
    const std::size_t below = beside ? begin : indent + 4;
    const Page::Words sentence = wrapped_words(row.back(), kWidth - below);
    if (beside) line += sentence.front();
    page.line(indent, line);
    for (std::size_t i = beside ? 1 : 0; i < sentence.size(); ++i) {
      if (!sentence[i].empty()) page.line(below, sentence[i]);
    }
  }
}

std::string in_quotes_if_empty(const std::string& value) { return value.empty() ? "''" : value; }

const std::string* given(const Described& described, const std::string& property) {
  if (!described.module) return nullptr;
  for (const model::PropertyValue& value : described.module->properties) {
    if (value.name == property) return &value.value;
  }
  return nullptr;
}

void add_module(Page& page, const model::Module& module) {
  std::string how = fmt::format("{}, {}", to_text(module.type), to_text(module.operation));
  if (module.period) how += " every " + to_text(*module.period);
  if (module.deadline) how += " within " + to_text(*module.deadline);
  if (!module.executor.empty()) how += ", on executor " + module.executor;
  page.line(2, "module      " + how);
  if (!module.arguments.empty())
    page.line(2, "arguments   " + on_one_line(model::in_one_line(module.arguments)));
}

/// The type of a request or reply as the user declared it, without the envelope that Takt adds.
const std::string& inner_type(const model::Type& type) {
  const auto inner = std::find_if(type.fields.begin(), type.fields.end(), [](const model::Field& field) {
    return field.scalar == model::Scalar::structure;
  });
  return inner == type.fields.end() ? type.name : inner->type_name;
}

/// Adds one line for each service and each client, which have two ports each.
void add_services(Page& page, const std::vector<model::Port>& ports) {
  std::vector<Page::Words> table;
  for (const model::Port& request : ports) {
    if (request.role == model::Role::plain || !request.name.ends_with(model::kRequestPort)) continue;
    const std::string name = model::name_of_service(request);
    const auto reply = std::find_if(ports.begin(), ports.end(), [&](const model::Port& port) {
      return port.name == name + model::kReplyPort;
    });
    table.push_back(
        {request.role == model::Role::client ? "client" : "service", name,
         inner_type(request.type) + " -> " + (reply == ports.end() ? "?" : inner_type(reply->type)),
         request.text});
  }
  if (table.empty()) return;
  page.line(2, "services");
  rows(page, 4, table);
}

void add_ports(Page& page, const Described& described) {
  const std::vector<model::Port>& all = described.component.ports;
  std::vector<model::Port> ports;
  std::copy_if(all.begin(), all.end(), std::back_inserter(ports),
               [](const model::Port& port) { return port.role == model::Role::plain; });
  page.line(2, ports.empty() ? "ports       none" : "ports");
  std::vector<Page::Words> heads;
  for (const model::Port& port : ports)
    heads.push_back({to_text(port.direction), port.name, port.type.name, port.text});
  const std::vector<std::size_t> widths = Page::widths_of(heads);
  for (std::size_t i = 0; i < ports.size(); ++i) {
    page.line(4, fmt::format("{:<5}  {:<{}}  {}", heads[i][0], heads[i][1], widths[1], heads[i][2]));
    if (!ports[i].text.empty()) page.sentence(11, on_one_line(ports[i].text));
    const std::string safe =
        described.module ? model::read_safe(*described.module, ports[i]).json : ports[i].safe;
    if (!safe.empty()) page.sentence(11, "safe: " + safe);
    Page::Words fields;
    for (const model::Field& field : ports[i].type.fields)
      fields.push_back(spelled(field) + " " + field.name +
                       (field.unit.empty() ? "" : " (" + field.unit + ")"));
    page.words(11, "", fields);
    std::set<std::string> listed;
    for (const model::Field& field : ports[i].type.fields) {
      Page::Words values = field.enumerators;
      if (values.empty() || !listed.insert(field.type_name).second) continue;
      values[0] = field.type_name + ": " + values[0];
      page.words(11, "", values);
    }
  }
}

void add_properties(Page& page, const Described& described) {
  const host::Description& component = described.component;
  const auto is_declared = [&](const std::string& name) {
    return std::any_of(component.properties.begin(), component.properties.end(),
                       [&](const auto& property) { return property.name == name; });
  };
  if (component.properties.empty()) {
    page.line(2, "properties  " + std::string{!component.takes_any_property() ? "none"
                                              : component.interface == "c"
                                                  ? "any name; initialize() reads the values"
                                                  : "any name; each becomes an argument NAME=VALUE"});
  } else {
    page.line(2, "properties");
    std::vector<Page::Words> table{
        {"name", "type", "default", described.module ? "given" : "", "range", "unit", ""}};
    for (const host::PropertyDescription& p : component.properties) {
      const std::string* value = given(described, p.name);
      table.push_back({p.name, p.type, in_quotes_if_empty(p.default_value), value == nullptr ? "" : *value,
                       p.range, p.unit, p.text});
    }
    rows(page, 4, table);
  }
  if (!described.module) return;
  for (const model::PropertyValue& value : described.module->properties) {
    if (!is_declared(value.name)) page.line(4, on_one_line(value.name + " = " + value.value));
  }
}

/// A valid module name, made from the name of the component's file.
std::string proposed_name(const std::string& path) {
  std::string name = model::file_stem(path).substr(0, model::kMaxNameLength);
  for (char& c : name) {
    if (!model::is_valid_name(std::string{"_"} + c)) c = '_';
  }
  if (!model::is_valid_name(name)) name = "_" + name.substr(0, model::kMaxNameLength - 1);
  return name;
}

/// True if a descriptor cannot express the property's default. describe_xml() leaves such a property out.
bool is_inexpressible(const host::PropertyDescription& property) {
  const std::string& value = property.default_value;
  const auto has_no_reference = [](char c) {
    return static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n' && c != '\r';
  };
  return (property.type == "double" && (value.ends_with("inf") || value.ends_with("nan"))) ||
         std::any_of(value.begin(), value.end(), has_no_reference);
}

bool has_event(const host::Description& component) {
  return std::any_of(component.ports.begin(), component.ports.end(), [](const model::Port& port) {
    return port.role == model::Role::plain && port.direction == model::Direction::event;
  });
}

model::Operation proposed_operation(const Described& described) {
  const host::Description& component = described.component;
  if (const auto known = operation_of(described)) return *known;
  const bool has_condition =
      std::find(component.hooks.begin(), component.hooks.end(), "condition") != component.hooks.end();
  return has_event(component) || has_condition ? model::Operation::sporadic : model::Operation::periodic;
}

}  // namespace

std::optional<model::Operation> operation_of(const Described& described) {
  if (described.module) return described.module->operation;
  for (const auto operation :
       {model::Operation::periodic, model::Operation::sporadic, model::Operation::non_real}) {
    if (described.component.operation == to_text(operation)) return operation;
  }
  return std::nullopt;
}

std::string describe_text(const Described& described, Style style) {
  const host::Description& component = described.component;
  Page page{style};
  const std::string name =
      described.module ? *described.device + "." + described.module->name : on_one_line(component.name);
  if (component.text.empty())
    page.line(0, page.bold(name));
  else
    page.heading(0, name, component.text);
  page.line(2, "file        " + on_one_line(described.path));
  page.line(2, "version     " + (component.version.empty() ? "not stated" : component.version) + ", hash " +
                   described.hash);
  page.line(2, "interface   " + component.interface +
                   (component.operation.empty() ? "" : ", " + component.operation));
  if (described.module) add_module(page, *described.module);
  if (!component.hooks.empty()) page.words(2, "hooks       ", component.hooks);
  if (component.saved)
    page.line(
        2, fmt::format("saved       {} bytes, version {}", component.saved->bytes, component.saved->version));
  add_properties(page, described);
  add_ports(page, described);
  add_services(page, component.ports);
  return std::move(page).take();
}

std::string describe_json(const Described& described) {
  auto object = model::parse_json(host::to_json(described.component));
  object["file"] = described.path;
  object["hash"] = described.hash;
  if (described.module) {
    const model::Module& module = *described.module;
    nlohmann::ordered_json values = nlohmann::ordered_json::object();
    for (const model::PropertyValue& value : module.properties) values[value.name] = value.value;
    object["module"] = {{"device", *described.device},   {"name", module.name},
                        {"type", to_text(module.type)},  {"operation", to_text(module.operation)},
                        {"arguments", module.arguments}, {"given", values}};
  }
  return model::json_text(object) + "\n";
}

std::string describe_xml(const Described& described) {
  const host::Description& component = described.component;
  const model::Operation operation = proposed_operation(described);
  std::string text = "<module>\n";
  if (!component.text.empty()) {
    std::string sentence = component.text;
    for (auto at = sentence.find("--"); at != std::string::npos; at = sentence.find("--"))
      sentence.erase(at, 1);
    text += fmt::format("  <!-- {} -->\n", sentence);
  }
  text += fmt::format("  <name>{}</name>\n", proposed_name(described.path));
  text += fmt::format("  <filename>{}</filename>\n",
                      escaped(std::filesystem::path{described.path}.filename().string()));
  text +=
      fmt::format("  <moduletype>{}</moduletype>\n", component.interface == "process" ? "process" : "thread");
  text += fmt::format("  <operationtype>{}</operationtype>\n", to_text(operation));
  if (operation == model::Operation::periodic) text += "  <period>1ms</period>\n";
  if (operation == model::Operation::sporadic) {
    text += "  <deadline>1ms</deadline>\n";
    if (has_event(component))
      text += "  <dispatch>immediate</dispatch> <!-- needs a connected event port -->\n";
  }
  if (operation != model::Operation::non_real)
    text += "  <priority>1</priority> <!-- modules with lower values run first -->\n";
  if (described.module && !described.module->arguments.empty()) {
    text += "  <arguments>\n";
    for (const std::string& argument : described.module->arguments)
      text += fmt::format("    <argument>{}</argument>\n", escaped(argument));
    text += "  </arguments>\n";
  }
  if (!std::all_of(component.properties.begin(), component.properties.end(), is_inexpressible)) {
    text += "  <property>\n";
    for (const auto& p : component.properties) {
      if (is_inexpressible(p)) continue;
      text += fmt::format("    <value name=\"{}\">{}</value>\n", escaped(p.name), escaped(p.default_value));
    }
    text += "  </property>\n";
  }
  return text + "</module>\n";
}

std::string component_list_text(const std::vector<host::ComponentFile>& files, Style style) {
  std::map<std::string, std::vector<Page::Words>> folders;
  for (const host::ComponentFile& file : files) {
    const std::filesystem::path path{file.path};
    folders[path.parent_path().string()].push_back({path.filename().string(), file.interface, file.text});
  }
  Page page{style};
  for (const auto& [folder, all] : folders) {
    if (folder != folders.begin()->first) page.blank();
    page.line(0, page.bold(on_one_line(folder)));
    rows(page, 2, all);
  }
  return std::move(page).take();
}

std::string component_list_json(const std::vector<host::ComponentFile>& files) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const host::ComponentFile& file : files) {
    list.push_back({{"file", std::filesystem::path{file.path}.filename().string()},
                    {"path", file.path},
                    {"interface", file.interface},
                    {"text", file.text}});
  }
  return model::json_text({{"components", list}}) + "\n";
}

std::string escaped(const std::string& text) {
  std::string result;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t length = utf8_length(rest);
    const std::string_view character = rest.substr(0, std::max<std::size_t>(length, 1));
    rest.remove_prefix(character.size());
    const char c = character[0];
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (c == '"')
      result += "&quot;";
    else if (length == 0 || (is_control_character(character) && c != '\t' && c != '\n'))
      result += xml_reference(character);
    else
      result += character;
  }
  return result;
}

}  // namespace takt::tool
