// Safe values. Readers of an output receive its safe value while the module of the output does not execute,
// or when the samples are too old.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::model {

struct SafeReading {
  /// The safe value with all fields of its type, as JSON; empty: the output has no safe value.
  std::string json;
  std::vector<std::pair<Line, Problem>> problems;
};

/// Determines the safe value of a module's output: the safe value that the component defines, in which the
/// fields of the descriptor replace those of the component. If the component defines no safe value, the other
/// fields are zero. Reports fields of the descriptor that do not fit the port.
SafeReading read_safe(const Module& module, const Port& port);

/// Returns the safe value of an output as the bytes of a sample; empty if the output has none. All safe
/// values of the cell must be valid.
std::vector<std::byte> safe_bytes(const Module& module, const Port& port);

/// Returns true if the reader of this connection can receive the safe value of the writer. This requires that
/// the connection carries the latest value of a module and does not end at an event port. `to` is the
/// reader's port.
bool may_be_safe(const Connection& connection, const Port& to);

/// The safe value of one output, as it is sent to the devices that read the output.
struct SafeOutput {
  Endpoint port;
  std::string json;
  bool operator==(const SafeOutput& other) const = default;
};
/// Returns all outputs of a cell that have a safe value.
std::vector<SafeOutput> safe_outputs(const Cell& cell, const CellPorts& ports);
/// Converts the safe values to JSON, to send them to nodes.
std::string safe_json(const std::vector<SafeOutput>& outputs);
/// Converts the text of safe_json() to safe values. Returns an empty list if the text is not a list of safe
/// values. A missing or malformed member becomes an empty text.
std::vector<SafeOutput> parse_safe(const std::string& json);

/// Converts a sample from the hexadecimal digits that a component gives, for example "00ff", to JSON. Returns
/// an empty text if the bytes are not a sample of the type.
std::string safe_of_hex(const Type& type, const std::string& hex);

}  // namespace takt::model
