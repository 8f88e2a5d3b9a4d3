// Safe values: what readers of an output get while its module does not execute, or what it wrote is too old.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::model {

struct SafeReading {
  std::string json;  ///< all fields of the type; empty: the output has none
  std::vector<std::pair<Line, Problem>> problems;
};

/// Of an output of the module: what its component says, with the fields that the descriptor gives in place of
/// those. Where the component says nothing, a field that is not given is zero.
SafeReading read_safe(const Module& module, const Port& port);

/// The same as bytes of a sample, of a cell whose safe values were found right; empty: it has none.
std::vector<std::byte> safe_bytes(const Module& module, const Port& port);

/// A reader of this connection gets the safe value of its writer: it takes the latest value, and that is no
/// event.
bool may_be_safe(const Connection& connection, const Port& to);

/// The safe value of an output, for who reads it elsewhere.
struct SafeOutput {
  Endpoint port;
  std::string json;
  bool operator==(const SafeOutput& other) const = default;
};
/// All of a cell.
std::vector<SafeOutput> safe_outputs(const Cell& cell, const CellPorts& ports);
/// JSON, for nodes. What is none is left out.
std::string safe_json(const std::vector<SafeOutput>& outputs);
std::vector<SafeOutput> parse_safe(const std::string& json);

/// The bytes of a component's "00ff", as JSON; empty where they are no sample of the type.
std::string safe_of_hex(const Type& type, const std::string& hex);

}  // namespace takt::model
