#include <takt/model/ports.hpp>

#include <algorithm>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include <nlohmann/json.hpp>

#include <takt/core/words.hpp>
#include <takt/model/json.hpp>
#include <takt/model/safe.hpp>

namespace takt::model {

namespace {

using Json = nlohmann::ordered_json;

std::string unit_words(const Field& field) {
  return field.unit.empty() ? "no unit" : "the unit " + field.unit;
}

std::string fields_differ(const std::vector<Field>& first, const std::vector<Field>& second,
                          const std::string& prefix) {
  for (std::size_t i = 0; i < std::max(first.size(), second.size()); ++i) {
    if (i >= first.size()) return prefix + second[i].name + " is only in the second version";
    if (i >= second.size()) return prefix + first[i].name + " is only in the first version";
    const Field& a = first[i];
    const Field& b = second[i];
    const std::string name = prefix + a.name;
    if (a.name != b.name)
      return "where the first version has " + name + ", the second has " + prefix + b.name;
    if (spelled(a) != spelled(b))
      return name + " is " + spelled(a) + " in the first version and " + spelled(b) + " in the second";
    if (a.unit != b.unit)
      return name + " has " + unit_words(a) + " in the first version and " + unit_words(b) + " in the second";
    if (a.enumerators != b.enumerators) return name + " has different enumerators in the second version";
    if (std::string inner = fields_differ(a.fields, b.fields, name + "."); !inner.empty()) return inner;
  }
  return {};
}

struct ModuleIndex {
  std::size_t device;
  std::size_t module;
};

std::optional<ModuleIndex> find_index(const Cell& cell, const Endpoint& end) {
  for (std::size_t d = 0; d < cell.devices.size(); ++d) {
    if (cell.devices[d].name != end.device) continue;
    for (std::size_t m = 0; m < cell.devices[d].modules.size(); ++m) {
      if (cell.devices[d].modules[m].name == end.module) return ModuleIndex{d, m};
    }
  }
  return std::nullopt;
}

const std::vector<Port>* known(const CellPorts& ports, const ModuleIndex& index) {
  if (index.device >= ports.size() || index.module >= ports[index.device].size()) return nullptr;
  const ModulePorts& of = ports[index.device][index.module];
  return of ? &*of : nullptr;
}

/// Returns true if the name has the form PACKAGE::msg::dds_::NAME_.
bool is_ros2_message(std::string_view name) {
  constexpr std::string_view kMiddle = "::msg::dds_::";
  const std::size_t middle = name.find(kMiddle);
  if (middle == std::string_view::npos || middle == 0) return false;
  const std::string_view message = name.substr(middle + kMiddle.size());
  return message.size() > 1 && message.back() == '_' && message.find(':') == std::string_view::npos &&
         name.substr(0, middle).find(':') == std::string_view::npos;
}

class Check {
 public:
  Check(const Cell& cell, const CellPorts& ports) : cell_(cell), ports_(ports) {}

  Problems run() {
    for (const Connection& connection : cell_.connections) {
      if (connection.carries == Carries::samples) check(connection);
    }
    for (const Service& service : cell_.services) check(service);
    check_immediate();
    check_safe();
    return std::move(problems_);
  }

 private:
  void add(Line line, std::string what, std::string fix) {
    Problem problem = problem_at(cell_.texts(), line, std::move(what), std::move(fix));
    if (cell_.file.empty()) problem.where = "cell " + cell_.name;
    problems_.push_back(std::move(problem));
  }

  const Port* check_end(const Endpoint& end, bool output, Line line) {
    const auto index = find_index(cell_, end);
    if (!index) return nullptr;
    const std::vector<Port>* ports = known(ports_, *index);
    if (ports == nullptr) return nullptr;
    const std::string module = end.device + "." + end.module;
    std::vector<std::string_view> names;
    for (const Port& port : *ports) {
      if (port.role == Role::plain && (port.direction == Direction::out) == output)
        names.push_back(port.name);
    }
    const char* kind = output ? "output" : "input";
    const auto service = std::find_if(ports->begin(), ports->end(), [&](const Port& p) {
      return p.role != Role::plain && (name_of_service(p) == end.port || p.name == end.port);
    });
    if (service != ports->end()) {
      add(line,
          in_quotes(name_of_service(*service)) + " of module " + module + " is a " +
              (service->role == Role::client ? "client" : "service") + ", not a port",
          R"(connect it with <service client="..." server="..."/>)");
      return nullptr;
    }
    const auto found =
        std::find_if(ports->begin(), ports->end(), [&](const Port& p) { return p.name == end.port; });
    if (found == ports->end()) {
      add(line, "module " + module + " has no port " + in_quotes(end.port),
          names.empty() ? std::string{"it has no "} + kind : suggestion(end.port, names));
      return nullptr;
    }
    if ((found->direction == Direction::out) != output) {
      add(line, "port " + to_text(end) + " is an " + (output ? "input" : "output"),
          output ? std::string{"a connection goes from an output to an input; "} +
                       (names.empty() ? "module " + module + " has no output" : suggestion(end.port, names))
                 : std::string{"a connection goes from an output to an input; "} +
                       (names.empty() ? "module " + module + " has no input" : suggestion(end.port, names)));
      return nullptr;
    }
    return &*found;
  }

  /// Returns true if this end of a connection is an existing output (`output` true) or an existing input
  /// (`output` false).
  bool is_port(const Endpoint& end, bool output) const {
    const auto index = find_index(cell_, end);
    const std::vector<Port>* ports = index ? known(ports_, *index) : nullptr;
    return ports != nullptr && std::any_of(ports->begin(), ports->end(), [&](const Port& p) {
             return p.role == Role::plain && p.name == end.port && (p.direction == Direction::out) == output;
           });
  }

  void check(const Connection& connection) {
    if (connection.from.given() && connection.to.given() && is_port(connection.from, false) &&
        is_port(connection.to, true)) {
      add(connection.line,
          "the connection goes from input " + to_text(connection.from) + " to output " +
              to_text(connection.to),
          "a connection goes from an output to an input: swap 'from' and 'to'");
      return;
    }
    const Port* from = connection.from.given() ? check_end(connection.from, true, connection.line) : nullptr;
    const Port* to = connection.to.given() ? check_end(connection.to, false, connection.line) : nullptr;
    if (connection.ros2) {
      if (from != nullptr) check_message(connection.from, *from, connection.line);
      if (to != nullptr) check_message(connection.to, *to, connection.line);
    }
    if (from == nullptr || to == nullptr || from->type == to->type) return;
    if (from->type.name != to->type.name) {
      add(connection.line,
          "port " + to_text(connection.from) + " has type " + from->type.name + ", but port " +
              to_text(connection.to) + " has type " + to->type.name,
          "connect ports of the same type");
    } else {
      add(connection.line,
          "ports " + to_text(connection.from) + " and " + to_text(connection.to) +
              " have different versions of type " + from->type.name + ": " + difference(from->type, to->type),
          "build both components from the same IDL");
    }
  }

  /// The request port and the reply port of a service or client. Both are null if the module has no service
  /// or client with this name, or if its ports are not known.
  struct Halves {
    const Port* request = nullptr;
    const Port* reply = nullptr;
  };
  Halves check_service_end(const Endpoint& end, bool client, const Line& line) {
    const auto index = find_index(cell_, end);
    const std::vector<Port>* ports = index ? known(ports_, *index) : nullptr;
    if (ports == nullptr) return {};
    const char* kind = client ? "client" : "service";
    const std::string module = end.device + "." + end.module;
    Halves halves;
    std::vector<std::string> names;
    bool is_other = false;
    bool is_port = false;
    for (const Port& port : *ports) {
      const std::string name = name_of_service(port);
      if (port.role == Role::plain || (port.role == Role::client) != client) {
        (port.role == Role::plain ? is_port : is_other) |= name == end.port;
        continue;
      }
      const bool request = port.name.ends_with(kRequestPort);
      if (request) names.push_back(name);
      if (name == end.port) (request ? halves.request : halves.reply) = &port;
    }
    if (halves.request != nullptr && halves.reply != nullptr) return halves;
    if (is_other) {
      add(line,
          in_quotes(end.port) + " of module " + module + " is a " + (client ? "service" : "client") +
              ", not a " + kind,
          R"(client="..." names the client and server="..." names the service)");
    } else if (is_port) {
      add(line, in_quotes(end.port) + " of module " + module + " is a port, not a " + kind,
          "connect it with <connection from=\"...\" to=\"...\"/>");
    } else {
      add(line, "module " + module + " has no " + kind + " " + in_quotes(end.port),
          names.empty() ? std::string{"it has no "} + kind + " at all; name another module"
                        : suggestion(end.port, {names.begin(), names.end()}));
    }
    return {};
  }

  void check(const Service& service) {
    const Halves client = check_service_end(service.client, true, service.line);
    const Halves server = check_service_end(service.server, false, service.line);
    if (client.request == nullptr || server.request == nullptr) return;
    const auto compare = [&](const char* what, const Type& of_client, const Type& of_server) {
      // Returns the type that the component's author wrote in IDL. Takt adds fields around this type.
      const auto inner = [](const Type& type) {
        const auto found = std::find_if(type.fields.begin(), type.fields.end(),
                                        [](const Field& field) { return field.scalar == Scalar::structure; });
        return Type{found->type_name, found->fields};
      };
      if (of_client == of_server) return;
      const Type first = inner(of_client);
      const Type second = inner(of_server);
      if (first.name != second.name) {
        add(service.line,
            "client " + to_text(service.client) + " has " + what + " of type " + first.name +
                ", but those of service " + to_text(service.server) + " have type " + second.name,
            "connect a client and a service that have the same request and reply types");
      } else {
        add(service.line,
            "client " + to_text(service.client) + " and service " + to_text(service.server) +
                " have different versions of type " + first.name + ": " + difference(first, second),
            "build both components from the same IDL");
      }
    };
    compare("requests", client.request->type, server.request->type);
    compare("replies", client.reply->type, server.reply->type);
  }

  void check_message(const Endpoint& end, const Port& port, const Line& line) {
    if (is_ros2_message(port.type.name)) return;
    add(line, "port " + to_text(end) + " has type " + port.type.name + ", which is not a ROS 2 message",
        "give the port a ROS 2 message type, such as one from idl/ros2; its IDL name is "
        "PACKAGE::msg::dds_::NAME_");
  }

  void check_immediate() {
    for (const Device& device : cell_.devices) {
      for (const Module& module : device.modules) {
        if (module.dispatch != Dispatch::immediate) continue;
        const auto index = find_index(cell_, {device.name, module.name, {}});
        const std::vector<Port>* ports = index ? known(ports_, *index) : nullptr;
        if (ports == nullptr) continue;
        const Line line = module.lines.dispatch.given() ? module.lines.dispatch : module.line;
        const bool has_event = std::any_of(ports->begin(), ports->end(),
                                           [](const Port& p) { return p.direction == Direction::event; });
        if (!has_event) {
          add(line,
              "module " + module.name +
                  " has <dispatch>immediate</dispatch>, but no event port that could release it",
              "write <dispatch>row</dispatch>, or give the component an EventPort");
          continue;
        }
        const bool fed =
            std::any_of(cell_.connections.begin(), cell_.connections.end(), [&](const Connection& c) {
              if (c.to.device != device.name || c.to.module != module.name) return false;
              return std::any_of(ports->begin(), ports->end(), [&](const Port& p) {
                return p.direction == Direction::event && p.name == c.to.port;
              });
            });
        if (!fed) {
          add(line,
              "module " + module.name +
                  " has <dispatch>immediate</dispatch>, but none of its event ports is connected",
              "add a <connection> to one of its event ports");
        }
      }
    }
  }

  const Port* safe_output(const Device& device, const Module& module, const SafeValue& safe) {
    const auto index = find_index(cell_, {device.name, module.name, {}});
    const std::vector<Port>* ports = index ? known(ports_, *index) : nullptr;
    if (ports == nullptr) return nullptr;
    std::vector<std::string_view> names;
    bool is_input = false;
    for (const Port& port : *ports) {
      const bool output = port.role == Role::plain && port.direction == Direction::out;
      if (output && port.name == safe.name) return &port;
      if (output) names.emplace_back(port.name);
      is_input |= port.name == safe.name;
    }
    const std::string fix = names.empty() ? "it has no output" : suggestion(safe.name, names);
    add(safe.line,
        is_input ? "port " + to_text({device.name, module.name, safe.name}) +
                       " is an input and cannot have a safe value"
                 : "module " + device.name + "." + module.name + " has no output " + in_quotes(safe.name),
        fix);
    return nullptr;
  }

  void check_safe() {
    for (const Device& device : cell_.devices) {
      for (const Module& module : device.modules) {
        for (const SafeValue& safe : module.safe) {
          const Port* port = safe_output(device, module, safe);
          if (port == nullptr) continue;
          for (const auto& [line, problem] : read_safe(module, *port).problems)
            add(line, problem.what, problem.fix);
        }
      }
    }
  }

  const Cell& cell_;
  const CellPorts& ports_;
  Problems problems_;
};

std::optional<Direction> direction_of(std::string_view text) {
  for (const Direction direction : {Direction::in, Direction::event, Direction::out}) {
    if (text == to_text(direction)) return direction;
  }
  return std::nullopt;
}

/// Returns the role with this name. An empty text means Role::plain.
std::optional<Role> role_of(std::string_view text) {
  if (text.empty()) return Role::plain;
  for (const Role role : {Role::plain, Role::service, Role::handler, Role::client}) {
    if (text == to_text(role)) return role;
  }
  return std::nullopt;
}

}  // namespace

const char* to_text(Direction direction) {
  switch (direction) {
    case Direction::in:
      return "in";
    case Direction::event:
      return "event";
    case Direction::out:
      return "out";
  }
  return "?";
}

const char* to_text(Role role) {
  switch (role) {
    case Role::plain:
      return "port";
    case Role::service:
      return "service";
    case Role::handler:
      return "handler";
    case Role::client:
      return "client";
  }
  return "?";
}

std::string name_of_service(const Port& port) {
  return port.role == Role::plain ? port.name : port.name.substr(0, port.name.rfind('/'));
}

std::string ports_json(const std::vector<Port>& ports) {
  Json list = Json::array();
  for (const Port& port : ports) {
    list.push_back({{"name", port.name},
                    {"direction", to_text(port.direction)},
                    {"role", to_text(port.role)},
                    {"type", port.type.name},
                    {"description", to_text(port.type)},
                    {"text", port.text},
                    {"object", port.object},
                    {"safe", port.safe.empty() ? Json(nullptr) : parse_json(port.safe)}});
  }
  return json_text({{"ports", list}});
}

Result<std::vector<Port>> parse_ports(const std::string& text) {
  const Json value = parse_json(text);
  if (!value.is_object() || !value.contains("ports") || !value["ports"].is_array())
    return fail("the text is not a list of ports");
  std::vector<Port> ports;
  Problems problems;
  for (const Json& each : value["ports"]) {
    const auto string_of = [&each](const char* name) {
      return each.is_object() && each.contains(name) && each[name].is_string() ? each[name].get<std::string>()
                                                                               : "";
    };
    Port port{.name = string_of("name"), .direction = Direction::in, .type = {}, .text = string_of("text")};
    port.object = each.is_object() && each.contains("object") && each["object"] == true;
    const auto direction = direction_of(string_of("direction"));
    const auto role = role_of(string_of("role"));
    auto type = parse_type(string_of("description"));
    if (port.name.empty() || !direction || !role) {
      problems.push_back(fail("a port lacks a name, a direction or a role"));
    } else if (!type) {
      for (const Problem& problem : type.problems())
        problems.push_back(fail("port " + port.name + ": " + problem.what, problem.fix));
    } else {
      port.direction = *direction;
      port.role = *role;
      port.type = std::move(*type);
      // A component gives the safe value as hexadecimal digits; ports_json() writes it as a JSON object. This
      // function accepts both.
      if (const auto safe = each.find("safe"); safe != each.end() && safe->is_object())
        port.safe = json_text(*safe);
      else
        port.safe = safe_of_hex(port.type, string_of("safe"));
      ports.push_back(std::move(port));
    }
  }
  if (!problems.empty()) return problems;
  return ports;
}

const Port* find_port(const Cell& cell, const CellPorts& ports, const Endpoint& end) {
  const auto index = find_index(cell, end);
  const std::vector<Port>* of = index ? known(ports, *index) : nullptr;
  if (of == nullptr) return nullptr;
  const auto found =
      std::find_if(of->begin(), of->end(), [&](const Port& port) { return port.name == end.port; });
  return found == of->end() ? nullptr : &*found;
}

Problems check_connections(const Cell& cell, const CellPorts& ports) { return Check{cell, ports}.run(); }

std::vector<UnconnectedInputs> unconnected_inputs(const Cell& cell, const CellPorts& ports) {
  std::set<std::tuple<std::string_view, std::string_view, std::string_view>> connected;
  for (const Connection& c : cell.connections) connected.insert({c.to.device, c.to.module, c.to.port});
  std::vector<UnconnectedInputs> all;
  for (std::size_t d = 0; d < cell.devices.size(); ++d) {
    const Device& device = cell.devices[d];
    for (std::size_t m = 0; m < device.modules.size(); ++m) {
      const Module& module = device.modules[m];
      const std::vector<Port>* of_module = known(ports, {d, m});
      if (of_module == nullptr) continue;
      UnconnectedInputs found{device.name + "." + module.name, module.line, {}};
      for (const Port& port : *of_module) {
        const bool client = port.role == Role::client;
        if (port.direction == Direction::out || (port.role != Role::plain && !client)) continue;
        if (connected.contains({device.name, module.name, port.name})) continue;
        found.names.push_back((client ? "client " : "") + name_of_service(port));
      }
      if (!found.names.empty()) all.push_back(std::move(found));
    }
  }
  return all;
}

std::string spelled(const Field& field) {
  std::string text = field.type_name.empty() ? to_text(field.scalar) : field.type_name;
  if (field.scalar == Scalar::text) text += "<" + std::to_string(field.bound) + ">";
  if (field.sequence != 0) text = "sequence<" + text + ", " + std::to_string(field.sequence) + ">";
  for (const std::size_t dimension : field.dimensions) text += "[" + std::to_string(dimension) + "]";
  return text;
}

std::string difference(const Type& first, const Type& second) {
  if (first.name != second.name)
    return "the first type is " + first.name + " and the second type is " + second.name;
  return fields_differ(first.fields, second.fields, "");
}

}  // namespace takt::model
