#include <fmt/format.h>

#include "reports/describe_report.hpp"

namespace takt::tool {

namespace {

/// Writes XML elements, indented by their depth. An element without known content is left out.
class Elements {
 public:
  void open(const char* name) {
    indent();
    text_ += fmt::format("<{}>\n", name);
    ++depth_;
  }
  void close(const char* name) {
    --depth_;
    indent();
    text_ += fmt::format("</{}>\n", name);
  }
  void add(const char* name, const std::string& content) {
    if (content.empty()) return;
    indent();
    text_ += fmt::format("<{0}>{1}</{0}>\n", name, escaped(content));
  }
  [[nodiscard]] std::string take() && { return std::move(text_); }

 private:
  void indent() { text_.append(2 * depth_, ' '); }

  std::size_t depth_ = 0;
  std::string text_ = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
};

const char* exe_type(model::Operation operation) {
  switch (operation) {
    case model::Operation::periodic:
      return "PERIODIC";
    case model::Operation::sporadic:
      return "EVENTDRIVEN";
    case model::Operation::non_real:
      return "NONRT";
  }
  return "";
}

void add_variables(Elements& xml, const char* group, const char* name, const std::vector<model::Port>& ports,
                   bool outputs) {
  xml.open(group);
  for (const model::Port& port : ports) {
    if ((port.direction == model::Direction::out) != outputs) continue;
    xml.open(name);
    xml.add("name", port.name);
    xml.add("type", port.type.name);
    xml.add("description", port.text);
    xml.close(name);
  }
  xml.close(group);
}

}  // namespace

std::string iso22166_profile(const Described& described, std::optional<model::Operation> operation) {
  const host::Description& component = described.component;
  Elements xml;
  xml.open("module");
  xml.open("generalInfo");
  xml.add("moduleName", component.name);
  xml.add("description", component.text);
  xml.close("generalInfo");
  if (operation) xml.add("exeType", exe_type(*operation));
  xml.open("properties");
  for (const host::PropertyDescription& p : component.properties) {
    std::string value = p.default_value;
    if (described.module) {
      for (const model::PropertyValue& given : described.module->properties) {
        if (given.name == p.name) value = given.value;
      }
    }
    xml.open("property");
    xml.add("name", p.name);
    xml.add("type", p.type);
    xml.add("value", value);
    xml.add("unit", p.unit);
    xml.add("description", p.text);
    xml.close("property");
  }
  xml.close("properties");
  xml.open("ioVariables");
  add_variables(xml, "inputs", "input", component.ports, false);
  add_variables(xml, "outputs", "output", component.ports, true);
  xml.close("ioVariables");
  xml.close("module");
  return std::move(xml).take();
}

}  // namespace takt::tool
