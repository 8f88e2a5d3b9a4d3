// The ports of a cell's modules, as far as their components were found, and everything that its connections
// can be wrong about once these are known.
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

/// What a port is there for: samples of its own, or, with another one, a service or a client.
enum class Role {
  plain,
  service,  ///< its module answers requests itself
  handler,  ///< the same, on a thread of its own
  client,
};
/// "port", "service", "handler", "client"
const char* to_text(Role role);

struct Port {
  std::string name;
  Direction direction = Direction::in;
  Type type;
  std::string text;  ///< one sentence; may be empty
  /// A port in C++ of a thread module: within one host its samples are handed over as objects, not as bytes.
  bool object = false;
  Role role = Role::plain;
  /// Of an output, the safe value that its component gives it, as JSON of all fields; empty: none.
  std::string safe{};
  bool operator==(const Port&) const = default;
};

/// Of one module; none where its component is not known here.
using ModulePorts = std::optional<std::vector<Port>>;
/// Of a cell, by the index of the device and of its module.
using CellPorts = std::vector<std::vector<ModulePorts>>;

/// JSON, for whoever asks another process or device.
std::string ports_json(const std::vector<Port>& ports);
/// Fails on a text that is none, and on a type that no port can have; the problem names the port and the
/// field.
Result<std::vector<Port>> parse_ports(const std::string& json);

/// "reset" for reset/request and reset/reply; the whole name of a plain port.
std::string name_of_service(const Port& port);

/// The port of a module; null where it has none of that name, or its ports are not known.
const Port* find_port(const Cell& cell, const CellPorts& ports, const Endpoint& end);

/// What is wrong with the connections of a cell that validate() finds right: each with `file:line` and a fix.
/// A port does not exist or has the other direction, the types of the two ends differ (with the first
/// difference), a service is none or its client asks it for something else, a module that is dispatched at
/// once has no event port that is connected. Ends of which nothing is known are not judged.
Problems check_connections(const Cell& cell, const CellPorts& ports);

/// The type of a field: "double[6]", "sequence<octet, 8>", "string<15>", "motion::Mode".
std::string spelled(const Field& field);

/// The first difference between two types, for a message: "position is double[6] in the first and double[7]
/// in the second"; empty when they are equal.
std::string difference(const Type& first, const Type& second);

}  // namespace takt::model
