#include "read_cell.hpp"

#include <algorithm>
#include <optional>

#include <takt/core/words.hpp>
#include "element.hpp"
#include "read_module.hpp"

namespace takt::descriptor {

namespace {

// The shapes include <use>, <template> and <include>, because messages list the children that an element can
// have. But when a cell is read from the tree, the tree no longer contains these elements.
const Shape kRoot{.many = {"executor", "module", "use", "template", "include"}};
const Shape kCell{
    .attributes = {"name", "domain", "discovery", "peers", "server", "server-device", "security"},
    .many = {"device", "connection", "service", "template", "include"}};
const Shape kDevice{.attributes = {"name"}, .many = {"executor", "module", "use", "template", "include"}};
const Shape kExecutor{.attributes = {"name", "cpu", "priority", "wakeup", "spin", "overrun", "limit",
                                     "offsets", "timing", "host"}};
const Shape kConnection{.attributes = {"from", "to", "kind", "depth", "reliability", "deadline", "lifespan",
                                       "stale", "topic", "domain", "ros2"},
                        .telling = {{"latest", "kind"}, {"queue", "kind"}}};

const Shape kService{.attributes = {"client", "server"}};

class CellReader {
 public:
  CellReader(const std::string& file, Report& report) : report_(report) { reading_.cell.file = file; }

  Reading read(const Node& root) {
    const std::string_view name = root.name;
    reading_.cell.line = root.line;
    if (name == "root") {
      read_root(root);
    } else if (name == "cell") {
      read_cell_form(root);
    } else {
      report_.add(root.line, "unknown root element <" + brief(name) + ">",
                  root.name == "fragment"
                      ? "this file is a fragment for inclusion: use a descriptor that includes it"
                      : "the root element of a descriptor must be <root> or <cell>");
      reading_.gaps.devices = true;
      reading_.cell.name = "unread";
    }
    return std::move(reading_);
  }

 private:
  /// Reads the paper's form of a descriptor, which contains the modules of one device. The cell then has only
  /// this device.
  void read_root(const Node& xml) {
    const Element root{xml, kRoot, report_};
    reading_.cell.name = name_after(reading_.cell.file);
    read_device(root, reading_.cell.name);
  }

  void read_cell_form(const Node& xml) {
    const Element cell{xml, kCell, report_};
    const auto name = cell.required_attribute("name");
    reading_.cell.name = name ? name->trimmed() : "unread";
    if (const auto given = cell.attribute("domain")) {
      const auto number = read_number(*given, {0, model::kMaxDomain}, report_);
      reading_.cell.domain = number ? static_cast<int>(*number) : 0;
      reading_.cell.domain_given = true;
    }
    read_discovery(cell);
    if (const auto given = cell.attribute("security")) {
      const auto choice = read_choice(*given, {"optional", "required"}, report_);
      reading_.cell.security_required = choice && *choice == 1;
    }
    reading_.gaps.devices = cell.has_unknown_children();
    for (const Node* child : cell.children("device")) {
      if (report_.full()) break;
      const Element device{*child, kDevice, report_};
      const auto device_name = device.required_attribute("name");
      if (!device_name) reading_.gaps.devices = true;
      read_device(device, device_name ? device_name->trimmed() : stand_in());
    }
    for (const Node* child : cell.children("connection")) {
      // One connection more than the limit is enough for validate() to reject the cell.
      if (report_.full() || reading_.cell.connections.size() > model::kMaxConnections) break;
      read_connection(*child);
    }
    for (const Node* child : cell.children("service")) {
      if (report_.full() || reading_.cell.services.size() > model::kMaxConnections) break;
      read_service(*child);
    }
  }

  void read_service(const Node& xml) {
    const Element element{xml, kService, report_};
    model::Service service;
    service.line = element.line();
    const bool client = read_side(element, "client", service.client);
    const bool server = read_side(element, "server", service.server);
    reading_.cell.services.push_back(std::move(service));
    reading_.gaps.without_sides.push_back(!client || !server);
  }

  bool read_side(const Element& element, const char* side, model::Endpoint& end) {
    const auto given = element.required_attribute(side);
    if (!given) return false;
    end = endpoint(given->trimmed());
    return true;
  }

  void read_discovery(const Element& cell) {
    using Kind = model::Discovery::Kind;
    model::Discovery& discovery = reading_.cell.discovery;
    bool& gap = reading_.gaps.discovery;
    for (const char* name : {"discovery", "peers", "server", "server-device"}) {
      if (cell.was_meant(name)) gap = true;
    }
    if (const auto given = cell.attribute("discovery")) {
      constexpr Kind kKinds[] = {Kind::multicast, Kind::peers, Kind::server};
      const auto choice = read_choice(*given, {"multicast", "peers", "server"}, report_);
      if (choice) discovery.kind = kKinds[*choice];
      if (!choice) gap = true;
    }
    if (const auto given = cell.attribute("peers")) {
      const std::string text = given->text;
      constexpr const char* kBlanks = " \t\r\n";
      std::size_t at = text.find_first_not_of(kBlanks);
      while (at != std::string::npos && discovery.peers.size() <= model::kMaxPeers) {
        const std::size_t end = std::min(text.find_first_of(kBlanks, at), text.size());
        discovery.peers.push_back(text.substr(at, end - at));
        at = text.find_first_not_of(kBlanks, end);
      }
      if (discovery.peers.empty()) {
        report_.add(given->line, given->what + " is empty",
                    "name at least one, as in peers=\"10.0.0.1 line.local\"");
        gap = true;
      }
    }
    if (const auto given = cell.attribute("server")) {
      discovery.server = given->trimmed();
      if (discovery.server.empty()) {
        report_.add(given->line, given->what + " is empty",
                    "give its address, as in server=\"10.0.0.1:11811\"");
        gap = true;
      }
    }
    if (const auto given = cell.attribute("server-device")) {
      reading_.cell.server_device = given->trimmed();
      if (reading_.cell.server_device.empty()) {
        report_.add(given->line, given->what + " is empty",
                    "name the device whose node starts the server, or remove the attribute");
        gap = true;
      }
    }
  }

  void read_device(const Element& element, const std::string& name) {
    model::Device device;
    device.name = name;
    device.line = element.line();
    model::Gaps::OfDevice gaps{.executors = element.has_unknown_children(),
                               .modules = element.has_unknown_children()};
    for (const Node* child : element.children("executor")) {
      if (report_.full()) break;
      device.executors.push_back(read_executor(*child, gaps));
    }
    if (device.executors.empty()) device.executors.emplace_back().line = device.line;
    for (const Node* child : element.children("module")) {
      if (report_.full()) break;
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

  model::Executor read_executor(const Node& xml, model::Gaps::OfDevice& gaps) {
    const Element element{xml, kExecutor, report_};
    model::Executor executor;
    executor.line = element.line();
    const auto name = element.required_attribute("name");
    if (!name) gaps.executors = true;
    executor.name = name ? name->trimmed() : stand_in();
    if (const auto given = element.attribute("cpu")) {
      const auto number = read_number(*given, {0, model::kMaxCpu}, report_);
      if (number) executor.cpu = static_cast<int>(*number);
    }
    if (const auto given = element.attribute("priority")) {
      executor.rate_monotonic = given->trimmed() == "auto";
      const auto number =
          executor.rate_monotonic
              ? std::nullopt
              : read_number(*given, {model::kMinExecutorPriority, model::kMaxExecutorPriority}, report_,
                            " or \"auto\"");
      if (number) executor.priority = static_cast<int>(*number);
    }
    if (const auto given = element.attribute("wakeup")) {
      constexpr model::Wakeup kWakeups[] = {model::Wakeup::sleep, model::Wakeup::hybrid, model::Wakeup::spin};
      const auto choice = read_choice(*given, {"sleep", "hybrid", "spin"}, report_);
      if (choice) executor.wakeup = kWakeups[*choice];
    }
    if (const auto given = element.attribute("spin")) {
      const auto percent = read_number(*given, {0, model::kMaxSpinPercent}, report_, " of percent");
      if (percent) executor.spin_share = static_cast<double>(*percent) / 100;
      if (executor.wakeup != model::Wakeup::hybrid) {
        report_.add(given->line,
                    "executor " + in_quotes(executor.name) + " has spin, but wakeup=\"" +
                        to_text(executor.wakeup) + "\"",
                    "remove spin, or set wakeup=\"hybrid\"");
      }
    }
    read_contracts(element, executor);
    return executor;
  }

  void read_contracts(const Element& element, model::Executor& executor) {
    const auto limit = element.attribute("limit");
    if (const auto given = element.attribute("overrun")) {
      executor.overrun = read_contract(*given, limit, report_);
    } else if (limit && !element.was_meant("overrun")) {
      report_.add(limit->line, "executor " + in_quotes(executor.name) + " has a limit but no overrun",
                  "set overrun=\"catch-up\", or remove the limit");
    }
    if (const auto given = element.attribute("offsets")) {
      if (read_choice(*given, {"given", "auto"}, report_) == 1U) executor.offsets = model::Offsets::automatic;
    }
    if (const auto given = element.attribute("timing")) {
      if (read_choice(*given, {"direct", "let"}, report_) == 1U) executor.timing = model::Timing::let;
    }
    if (const auto given = element.attribute("host")) {
      if (const auto choice = read_choice(*given, {"shared", "own"}, report_))
        executor.own_host = *choice == 1;
    }
  }

  void read_connection(const Node& xml) {
    const Element element{xml, kConnection, report_};
    model::Connection connection;
    connection.line = element.line();
    const bool from_known = read_end(element, "from", connection.from);
    const bool to_known = read_end(element, "to", connection.to);
    read_kind(element, connection);
    read_times(element, connection);
    if (const auto given = element.attribute("stale")) {
      if (read_choice(*given, {"hold", "error"}, report_) == 1U) connection.stale = model::Stale::error;
    }
    read_topic(element, connection);
    reading_.cell.connections.push_back(std::move(connection));
    reading_.gaps.without_ends.push_back(!from_known || !to_known || element.has_unknown_children());
  }

  /// Reads one end of a connection, which the descriptor may omit. Returns false if the end is given but
  /// cannot be read.
  bool read_end(const Element& element, const char* side, model::Endpoint& end) {
    const auto given = element.attribute(side);
    if (!given) return !element.was_meant(side);
    const std::string text = given->trimmed();
    end = endpoint(text);
    // An end such as ".." has three empty parts. Report it here, because it would later count as omitted.
    if (text.find_first_not_of('.') != std::string::npos) return true;
    report_.add(given->line, given->what + (text.empty() ? " is empty" : " is not valid: " + in_quotes(text)),
                "write device.module.port");
    return false;
  }

  void read_kind(const Element& element, model::Connection& connection) {
    bool known = !element.was_meant("kind");
    if (const auto given = element.attribute("kind")) {
      const auto choice = read_choice(*given, {"latest", "queue"}, report_);
      known = choice.has_value();
      if (choice == 1U) connection.kind = model::ConnectionKind::queue;
    }
    // If the kind could not be read, treat the connection as a queue, because a queue may have every
    // attribute of a connection.
    if (!known) connection.kind = model::ConnectionKind::queue;
    const bool queue = connection.kind == model::ConnectionKind::queue;

    if (const auto given = element.attribute("depth")) {
      connection.depth_given = true;
      const auto number = read_number(*given, {1, model::kMaxDepth}, report_);
      if (!queue) {
        report_.add(given->line, "a connection of kind latest has a depth",
                    "remove depth, or set kind=\"queue\"");
      } else if (number) {
        connection.depth = static_cast<int>(*number);
      }
    }
    // A queue is reliable by default, because each of its samples matters. A latest value is not reliable by
    // default, because the next value soon replaces a lost one.
    connection.reliability = queue ? model::Reliability::reliable : model::Reliability::best_effort;
    if (const auto given = element.attribute("reliability")) {
      constexpr model::Reliability kReliabilities[] = {model::Reliability::best_effort,
                                                       model::Reliability::reliable};
      const auto choice = read_choice(*given, {"best-effort", "reliable"}, report_);
      if (choice) connection.reliability = kReliabilities[*choice];
    }
  }

  void read_times(const Element& element, model::Connection& connection) {
    const auto read = [&](const char* name) -> std::optional<Nanoseconds> {
      if (const auto given = element.attribute(name)) {
        return read_time(*given, {.from = Nanoseconds{1}}, report_).value_or(Nanoseconds{1});
      }
      if (element.was_meant(name)) return Nanoseconds{1};
      return std::nullopt;
    };
    connection.deadline = read("deadline");
    connection.lifespan = read("lifespan");
  }

  void read_topic(const Element& element, model::Connection& connection) {
    if (const auto given = element.attribute("topic")) {
      connection.topic = given->trimmed();
      if (connection.topic.empty()) {
        report_.add(given->line, given->what + " is empty",
                    "name a topic, or remove the attribute: the connection then gets its own topic");
        connection.topic = stand_in();
      }
    } else if (element.was_meant("topic")) {
      connection.topic = stand_in();
    }
    if (const auto given = element.attribute("domain")) {
      const auto number = read_number(*given, {0, model::kMaxDomain}, report_);
      if (number) connection.domain = static_cast<int>(*number);
    }
    if (const auto given = element.attribute("ros2")) {
      if (read_choice(*given, {"false", "true"}, report_) == 1U) read_ros2(element, connection);
    }
  }

  /// Sets the connection's topic to the DDS name of a ROS 2 topic such as "/arm/joint_states". Also makes the
  /// writer reliable by default, because ROS 2 readers require this by default.
  void read_ros2(const Element& element, model::Connection& connection) {
    connection.ros2 = true;
    if (!element.attribute("reliability") && !element.was_meant("reliability") && connection.from.given())
      connection.reliability = model::Reliability::reliable;
    if (const auto given = element.attribute("topic"); given && !given->trimmed().empty()) {
      const std::string name = given->trimmed();
      connection.topic = model::kRos2Topics + (name.front() == '/' ? name.substr(1) : name);
    }
  }

  /// Splits device.module.port into its parts. If the text has more or fewer parts, the result is an endpoint
  /// that validate() rejects and quotes.
  static model::Endpoint endpoint(const std::string& text) {
    const std::size_t first = text.find('.');
    if (first == std::string::npos) return {text, {}, {}};
    const std::size_t second = text.find('.', first + 1);
    if (second == std::string::npos) return {text.substr(0, first), text.substr(first + 1), {}};
    return {text.substr(0, first), text.substr(first + 1, second - first - 1), text.substr(second + 1)};
  }

  /// Returns a valid, unique name in place of a name that could not be read.
  std::string stand_in() { return "_unread-" + std::to_string(++stand_ins_); }

  Report& report_;
  Reading reading_;
  int stand_ins_ = 0;
};

}  // namespace

std::string name_after(const std::string& file) {
  std::string name = model::file_stem(file).substr(0, model::kMaxNameLength);
  for (std::size_t i = 0; i < name.size(); ++i) {
    // A character is allowed at position i if "a" followed by the character is a valid name. At position 0,
    // the character alone must be a valid name.
    const std::string probe = i == 0 ? name.substr(0, 1) : "a" + name.substr(i, 1);
    if (!model::is_valid_name(probe)) name[i] = '_';
  }
  return name.empty() ? "cell" : name;
}

Reading read_cell(const Node& root, const std::string& file, Report& report) {
  return CellReader{file, report}.read(root);
}

}  // namespace takt::descriptor
