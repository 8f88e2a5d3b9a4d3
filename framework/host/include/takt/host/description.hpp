// The description of a component as data, which `takt describe` shows.
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
  std::string range{};  ///< for example "0 to 10" or "fast or slow"; this and all members below may be empty
  std::string min{};    ///< only for numbers
  std::string max{};
  std::string unit{};
  std::string text{};

  bool operator==(const PropertyDescription&) const = default;
};

/// The state that a component saves, so that it survives a crash; see takt::Saved.
struct SavedDescription {
  std::uint32_t version = 0;
  std::uint32_t bytes = 0;

  bool operator==(const SavedDescription&) const = default;
};

struct Description {
  std::string name{};        ///< the name of the class; for a C module or a program, the file's stem
  std::string text{};        ///< one sentence about what the component does; may be empty
  std::string version{};     ///< the text of TAKT_COMPONENT_VERSION(); may be empty
  std::string interface {};  ///< "c++", "c" or "process"
  /// Only for programs: "periodic" or "sporadic", depending on the init function that the program calls;
  /// "non-real" if the program is not linked with libtakt_process; empty if the program did not describe
  /// itself.
  std::string operation{};
  std::vector<std::string> hooks{};  ///< only for C modules
  /// If a C module or a program declares no properties, it accepts any property and interprets the property's
  /// value itself.
  std::vector<PropertyDescription> properties{};
  std::vector<model::Port> ports{};
  std::optional<SavedDescription> saved{};

  [[nodiscard]] bool takes_any_property() const { return interface != "c++" && properties.empty(); }
};

/// Returns the description as a JSON object, {"name", "text", "version", "interface", "operation", "hooks",
/// "properties", "ports", "saved"}. See docs/describe.md.
std::string to_json(const Description& description);

/// Parses a program's or loaded component's report of its properties: [{"name", "type", "default", "range",
/// "min", "max", "unit", "text"}, ...], where each value is a string. Fails if the text is not such a list.
Result<std::vector<PropertyDescription>> parse_properties(const std::string& json);

}  // namespace takt::host
