// Safe values. Readers of an output receive its safe value while the output's module does not execute, or
// when its samples are too old.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::model {

struct SafeReading {
  std::string json;  ///< the safe value with all fields of its type; empty: the output has no safe value
  std::vector<std::pair<Line, Problem>> problems;
};

/// Determines the safe value of a module's output. It is the component's safe value, except for the fields
/// that the descriptor sets. If the component defines no safe value, the other fields are zero.
SafeReading read_safe(const Module& module, const Port& port);

/// The safe value of an output as the bytes of a sample; empty if the output has no safe value. All safe
/// values of the cell must be valid.
std::vector<std::byte> safe_bytes(const Module& module, const Port& port);

/// Returns true if the reader of this connection can receive the safe value of its writer. This is so if the
/// connection carries the latest value of a module and does not end at an event port.
bool may_be_safe(const Connection& connection, const Port& to);

/// The safe value of one output, sent to the readers on other devices.
struct SafeOutput {
  Endpoint port;
  std::string json;
  bool operator==(const SafeOutput& other) const = default;
};
/// Returns the safe values of all outputs of a cell that have one.
std::vector<SafeOutput> safe_outputs(const Cell& cell, const CellPorts& ports);
/// Converts the safe values to JSON, to send them to nodes.
std::string safe_json(const std::vector<SafeOutput>& outputs);
/// Reads the text that safe_json() returned. The result is empty if the text is not a list of safe values.
/// Missing or malformed members are read as empty.
std::vector<SafeOutput> parse_safe(const std::string& json);

/// Converts a sample that a component gives in hex, for example "00ff", to JSON. The result is empty if the
/// bytes are not a sample of the type.
std::string safe_of_hex(const Type& type, const std::string& hex);

}  // namespace takt::model
