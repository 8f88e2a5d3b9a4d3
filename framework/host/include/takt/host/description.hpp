// What a component is, as data: what `takt describe` shows.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/ports.hpp>

namespace takt::host {

struct PropertyDescription {
  std::string name{};
  std::string type{};  ///< "bool", "integer", "double", "string"
  std::string default_value{};
  std::string range{};  ///< "0 to 10", "fast or slow"; may be empty, as all below
  std::string min{};    ///< of a number
  std::string max{};
  std::string unit{};
  std::string text{};

  bool operator==(const PropertyDescription&) const = default;
};

/// What it keeps over a crash, see takt::Saved.
struct SavedDescription {
  std::uint32_t version = 0;
  std::uint32_t bytes = 0;

  bool operator==(const SavedDescription&) const = default;
};

struct Description {
  std::string name{};        ///< of the class; of a C module or a program, the file's stem
  std::string text{};        ///< one sentence that says what it does; may be empty
  std::string interface {};  ///< "c++", "c" or "process"
  /// Of a program: "periodic" or "sporadic", as it calls; "non-real" when it is not linked with
  /// libtakt_process; empty when it did not say.
  std::string operation{};
  std::vector<std::string> hooks{};  ///< of a C module
  /// Of a C module or a program without any: it takes every property, and looks at them itself.
  std::vector<PropertyDescription> properties{};
  std::vector<model::Port> ports{};
  std::optional<SavedDescription> saved{};

  [[nodiscard]] bool takes_any_property() const { return interface != "c++" && properties.empty(); }
};

/// One object, {"name", "text", "interface", "operation", "hooks", "properties", "ports", "saved"}:
/// docs/describe.md.
std::string to_json(const Description& description);

/// From [{"name", "type", "default", "range", "min", "max", "unit", "text"}, ...], each a text, as a program
/// or a loaded component says it. Fails on a text that is none.
Result<std::vector<PropertyDescription>> parse_properties(const std::string& json);

}  // namespace takt::host
