// The ports of a cell's modules, as far as their components could be read. Also those checks of connections
// for which the ports must be known.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/type.hpp>

namespace takt::model {

enum class Direction { in, event, out };
/// Returns the direction as text: "in", "event" or "out".
const char* to_text(Direction direction);

/// What a port is used for. Each service, handler and client consists of two ports.
enum class Role {
  plain,    ///< carries ordinary samples, and belongs to no service or client
  service,  ///< one of the two ports of a service whose module answers requests in its run()
  handler,  ///< one of the two ports of a handler, which answers requests on another thread
  client,
};
/// Returns the role as text: "port", "service", "handler" or "client".
const char* to_text(Role role);

struct Port {
  std::string name;
  Direction direction = Direction::in;
  Type type;
  std::string text;  ///< a description of the port in one sentence; may be empty
  /// True for a C++ port of a thread module. Two such ports in one host exchange samples as C++ objects and
  /// not as bytes.
  bool object = false;
  Role role = Role::plain;
  /// For an output: the safe value that the component defines, as JSON with all fields of the type; empty if
  /// the component defines none.
  std::string safe{};
  bool operator==(const Port&) const = default;
};

/// The ports of one module; none if its component could not be read.
using ModulePorts = std::optional<std::vector<Port>>;
/// The ports of all modules of a cell, indexed by device and then by module.
using CellPorts = std::vector<std::vector<ModulePorts>>;

/// Converts ports to JSON, to send them to another process or device.
std::string ports_json(const std::vector<Port>& ports);
/// Converts the text of ports_json() to ports. Fails if the text is not a list of ports, or if a port has an
/// invalid type. The problem names the port and the field.
Result<std::vector<Port>> parse_ports(const std::string& json);

/// Returns the name that the component's author gave: "reset" for the ports reset/request and reset/reply;
/// for a plain port, its whole name.
std::string name_of_service(const Port& port);

/// Returns the port that an endpoint names; null if the module has no such port, or if its ports are not
/// known.
const Port* find_port(const Cell& cell, const CellPorts& ports, const Endpoint& end);

/// Checks the connections, services and safe values of a cell that validate() accepts. Returns one problem,
/// with `file:line` and a fix, for each of these mistakes:
/// - A port does not exist or has the wrong direction.
/// - The types of the two ports differ; the problem describes the first difference.
/// - A <service> names a port that is not a service or client, or their types differ.
/// - A module with immediate dispatch has no connected event port.
/// - A safe value does not fit its port.
/// Skips modules whose ports are not known.
Problems check_connections(const Cell& cell, const CellPorts& ports);

/// The inputs, event ports and clients of a module that have no connection, so that they never get a value.
struct UnconnectedInputs {
  std::string module;              ///< DEVICE.MODULE
  Line line{};                     ///< the line of the module
  std::vector<std::string> names;  ///< for example "setpoint" or "client home"
};
/// Returns an entry for each module that has such inputs. Skips modules whose ports are not known.
std::vector<UnconnectedInputs> unconnected_inputs(const Cell& cell, const CellPorts& ports);

/// Returns the type of a field as it is written in IDL, for example "double[6]", "sequence<octet, 8>",
/// "string<15>" or "motion::Mode".
std::string spelled(const Field& field);

/// Describes the first difference between two types, for example "position is double[6] in the first version
/// and double[7] in the second"; empty if the types are equal.
std::string difference(const Type& first, const Type& second);

}  // namespace takt::model
