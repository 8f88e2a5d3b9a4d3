// Safe values: the values that readers of an output get while its module does not execute, or when its
// samples are too old.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::model {

struct SafeReading {
  std::string json;  ///< all fields of the type; empty: the output has no safe value
  std::vector<std::pair<Line, Problem>> problems;
};

/// The safe value of an output of the module: the component's safe value, in which the fields of the
/// descriptor replace those of the component. If the component defines none, fields that the descriptor does
/// not set are zero.
SafeReading read_safe(const Module& module, const Port& port);

/// The safe value of an output as the bytes of a sample; empty if the output has none. Requires a cell whose
/// safe values are valid.
std::vector<std::byte> safe_bytes(const Module& module, const Port& port);

/// Whether the reader of this connection can get the safe value of its writer. It can if the connection
/// carries the latest value of a module and the reader's port is not an event port.
bool may_be_safe(const Connection& connection, const Port& to);

/// The safe value of an output, for readers on other devices.
struct SafeOutput {
  Endpoint port;
  std::string json;
  bool operator==(const SafeOutput& other) const = default;
};
/// The safe values of all outputs of a cell that have one.
std::vector<SafeOutput> safe_outputs(const Cell& cell, const CellPorts& ports);
/// The safe values as JSON, for nodes.
std::string safe_json(const std::vector<SafeOutput>& outputs);
/// Reads the text of safe_json(). Empty if the text is not such a list. Missing or malformed members are
/// empty.
std::vector<SafeOutput> parse_safe(const std::string& json);

/// The sample that a component gives in hex ("00ff"), as JSON; empty if it is not a sample of the type.
std::string safe_of_hex(const Type& type, const std::string& hex);

}  // namespace takt::model
