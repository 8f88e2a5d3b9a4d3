#include <takt/descriptor/read_cell.hpp>

#include <tinyxml2.h>

#include <takt/core/words.hpp>
#include <takt/descriptor/element.hpp>
#include <takt/descriptor/read_module.hpp>

namespace takt::descriptor {

namespace {

using tinyxml2::XMLElement;

const Shape kRoot{.many = {"executor", "module"}};
const Shape kCell{.attributes = {"name", "domain"}, .many = {"device", "connection"}};
const Shape kDevice{.attributes = {"name"}, .many = {"executor", "module"}};
const Shape kExecutor{.attributes = {"name", "cpu", "priority", "wakeup"}};
const Shape kConnection{.attributes = {"from", "to", "kind", "depth", "deadline", "stale"}};

class CellReader {
 public:
  CellReader(const std::string& file, Report& report) : report_(report) { reading_.cell.file = file; }

  Reading read(const XMLElement& root) {
    const std::string_view name = root.Name();
    reading_.cell.line = root.GetLineNum();
    if (name == "root") {
      read_root(root);
    } else if (name == "cell") {
      read_cell_form(root);
    } else {
      report_.add(root.GetLineNum(), "unknown root element <" + brief(name) + ">",
                  "a descriptor has one element <root> or <cell>");
      reading_.gaps.devices = true;
      reading_.cell.name = "unread";
    }
    return std::move(reading_);
  }

 private:
  /// The paper's form: the modules of one device that is the whole cell.
  void read_root(const XMLElement& xml) {
    const Element root{xml, kRoot, report_};
    reading_.cell.name = name_after(reading_.cell.file);
    read_device(root, reading_.cell.name);
  }

  void read_cell_form(const XMLElement& xml) {
    const Element cell{xml, kCell, report_};
    const auto name = cell.required_attribute("name");
    reading_.cell.name = name ? name->trimmed() : "unread";
    if (const auto given = cell.attribute("domain")) {
      const auto number = read_number(*given, {0, model::kMaxDomain}, "", report_);
      reading_.cell.domain = number ? static_cast<int>(*number) : 0;
      reading_.cell.domain_given = true;
    }
    reading_.gaps.devices = cell.has_unknown_children();
    for (const XMLElement* child : cell.children("device")) {
      const Element device{*child, kDevice, report_};
      const auto device_name = device.required_attribute("name");
      if (!device_name) reading_.gaps.devices = true;
      read_device(device, device_name ? device_name->trimmed() : stand_in());
    }
    for (const XMLElement* child : cell.children("connection")) read_connection(*child);
  }

  void read_device(const Element& element, const std::string& name) {
    model::Device device;
    device.name = name;
    device.line = element.line();
    model::Gaps::OfDevice gaps{.executors = element.has_unknown_children(),
                               .modules = element.has_unknown_children()};
    for (const XMLElement* child : element.children("executor")) {
      device.executors.push_back(read_executor(*child, gaps));
    }
    if (device.executors.empty()) device.executors.emplace_back().line = device.line;
    for (const XMLElement* child : element.children("module")) {
      ModuleReading module = read_module(*child, device.executors, report_);
      if (!module.name_known) {
        module.module.name = stand_in();
        gaps.modules = true;
      }
      device.modules.push_back(std::move(module.module));
    }
    reading_.cell.devices.push_back(std::move(device));
    reading_.gaps.of_device.push_back(gaps);
  }

  model::Executor read_executor(const XMLElement& xml, model::Gaps::OfDevice& gaps) {
    const Element element{xml, kExecutor, report_};
    model::Executor executor;
    executor.line = element.line();
    const auto name = element.required_attribute("name");
    if (!name) gaps.executors = true;
    executor.name = name ? name->trimmed() : stand_in();
    if (const auto given = element.attribute("cpu")) {
      const auto number = read_number(*given, {0, model::kMaxCpu}, "", report_);
      if (number) executor.cpu = static_cast<int>(*number);
    }
    if (const auto given = element.attribute("priority")) {
      const auto number =
          read_number(*given, {model::kMinExecutorPriority, model::kMaxExecutorPriority}, "", report_);
      if (number) executor.priority = static_cast<int>(*number);
    }
    if (const auto given = element.attribute("wakeup")) {
      constexpr model::Wakeup kWakeups[] = {model::Wakeup::sleep, model::Wakeup::hybrid, model::Wakeup::spin};
      const auto choice = read_choice(*given, {"sleep", "hybrid", "spin"}, report_);
      if (choice) executor.wakeup = kWakeups[*choice];
    }
    return executor;
  }

  void read_connection(const XMLElement& xml) {
    const Element element{xml, kConnection, report_};
    model::Connection connection;
    connection.line = element.line();
    const auto from = element.required_attribute("from");
    const auto to = element.required_attribute("to");
    if (from) connection.from = endpoint(from->trimmed());
    if (to) connection.to = endpoint(to->trimmed());

    bool kind_known = !element.was_meant("kind");
    if (const auto given = element.attribute("kind")) {
      const auto choice = read_choice(*given, {"latest", "queue"}, report_);
      kind_known = choice.has_value();
      if (choice == 1U) connection.kind = model::ConnectionKind::queue;
    }
    // A queue may have everything that a connection can have.
    if (!kind_known) connection.kind = model::ConnectionKind::queue;

    if (const auto given = element.attribute("depth")) {
      const auto number = read_number(*given, {1, model::kMaxDepth}, "", report_);
      if (connection.kind == model::ConnectionKind::latest) {
        report_.add(given->line, "a connection of kind latest has a depth",
                    "remove depth, or say kind=\"queue\"");
      } else if (number) {
        connection.depth = static_cast<int>(*number);
      }
    }
    if (const auto given = element.attribute("deadline")) {
      const auto number = read_number(*given, {.from = 1}, " of nanoseconds", report_);
      connection.deadline = Nanoseconds{number.value_or(1)};
    } else if (element.was_meant("deadline")) {
      connection.deadline = Nanoseconds{1};
    }
    if (const auto given = element.attribute("stale")) {
      if (read_choice(*given, {"hold", "error"}, report_) == 1U) connection.stale = model::Stale::error;
    }
    reading_.cell.connections.push_back(std::move(connection));
    reading_.gaps.without_ends.push_back(!from || !to);
  }

  /// device.module.port; what has other parts is refused by validate, which shows it as it was.
  static model::Endpoint endpoint(const std::string& text) {
    const std::size_t first = text.find('.');
    if (first == std::string::npos) return {text, {}, {}};
    const std::size_t second = text.find('.', first + 1);
    if (second == std::string::npos) return {text.substr(0, first), text.substr(first + 1), {}};
    return {text.substr(0, first), text.substr(first + 1, second - first - 1), text.substr(second + 1)};
  }

  /// A name for what could not be read: valid, and nobody else's.
  std::string stand_in() { return "_unread-" + std::to_string(++stand_ins_); }

  Report& report_;
  Reading reading_;
  int stand_ins_ = 0;
};

}  // namespace

std::string name_after(const std::string& file) {
  std::string name = model::file_stem(file).substr(0, model::kMaxNameLength);
  for (std::size_t i = 0; i < name.size(); ++i) {
    // "a" before a character shows whether it may stand inside a name.
    const std::string probe = i == 0 ? name.substr(0, 1) : "a" + name.substr(i, 1);
    if (!model::is_valid_name(probe)) name[i] = '_';
  }
  return name.empty() ? "cell" : name;
}

Reading read_cell(const XMLElement& root, const std::string& file, Report& report) {
  return CellReader{file, report}.read(root);
}

}  // namespace takt::descriptor
