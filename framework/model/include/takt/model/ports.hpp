// The ports of a cell's modules, for all components that were found, and the checks of connections that need
// these ports.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/type.hpp>

namespace takt::model {

enum class Direction { in, event, out };
/// "in", "event", "out"
const char* to_text(Direction direction);

/// The purpose of a port. A service, a handler and a client each consist of two ports.
enum class Role {
  plain,    ///< carries samples of its own
  service,  ///< its module answers the requests in its own run
  handler,  ///< a handler answers the requests on another thread
  client,
};
/// "port", "service", "handler", "client"
const char* to_text(Role role);

struct Port {
  std::string name;
  Direction direction = Direction::in;
  Type type;
  std::string text;  ///< description in one sentence; may be empty
  /// True for a C++ port of a thread module. Within one host its samples are passed as objects, not as bytes.
  bool object = false;
  Role role = Role::plain;
  /// For an output, the safe value that its component defines, as JSON with all fields; empty: none.
  std::string safe{};
  bool operator==(const Port&) const = default;
};

/// The ports of one module; none if its component is not known here.
using ModulePorts = std::optional<std::vector<Port>>;
/// The ports of a cell, by the index of the device and of its module.
using CellPorts = std::vector<std::vector<ModulePorts>>;

/// The ports as JSON, for another process or device.
std::string ports_json(const std::vector<Port>& ports);
/// Reads the text of ports_json(). Fails if the text is not a list of ports, or if it has a type that no port
/// can have. The problem names the port and the field.
Result<std::vector<Port>> parse_ports(const std::string& json);

/// The name that the author of the component gave: "reset" for reset/request and reset/reply, the whole name
/// for a plain port.
std::string name_of_service(const Port& port);

/// The port of a module; null if the module has no such port, or if its ports are not known.
const Port* find_port(const Cell& cell, const CellPorts& ports, const Endpoint& end);

/// Returns the problems of the connections of a cell that validate() accepts, each with `file:line` and a
/// fix:
/// - A port does not exist or has the wrong direction.
/// - The types of the two ends differ; the problem names the first difference.
/// - An end of a service is not a service or client, or their types differ.
/// - A module with immediate dispatch has no connected event port.
/// - A safe value does not fit its port. Does not check ends whose ports are not known.
Problems check_connections(const Cell& cell, const CellPorts& ports);

/// The type of a field: "double[6]", "sequence<octet, 8>", "string<15>", "motion::Mode".
std::string spelled(const Field& field);

/// The first difference between two types, for a message: "position is double[6] in the first and double[7]
/// in the second"; empty if they are equal.
std::string difference(const Type& first, const Type& second);

}  // namespace takt::model
