// Makes the output of `takt describe`, which shows components as text, as JSON, as XML for a descriptor, or
// as a module profile.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/host/description.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/cell.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// A component and, if the user gave a descriptor, a module of the cell that uses the component.
struct Described {
  std::string path;
  std::string hash;  ///< security::short_hash() of the file
  host::Description component;
  std::optional<std::string> cell{};  ///< the name of the module's cell, if the user gave a descriptor
  std::optional<std::string> device{};
  std::optional<model::Module> module{};
};

std::string describe_text(const Described& described, Style style);

/// The JSON object that docs/describe.md defines, on one line.
std::string describe_json(const Described& described);

/// A <module> element for a descriptor, with the default values. If operation_of() does not know the
/// operation type, a component with an event port or a condition is sporadic, and any other component is
/// periodic.
std::string describe_xml(const Described& described);

/// A module profile with the terms of ISO 22166-202; docs/describe.md explains the choice of terms.
/// `operation` is the operation type of the module, if known.
std::string iso22166_profile(const Described& described, std::optional<model::Operation> operation);

/// The operation type of a module, if the descriptor gives it or the functions that the component calls
/// reveal it.
std::optional<model::Operation> operation_of(const Described& described);

/// A list with one line per component, grouped by folder.
std::string component_list_text(const std::vector<host::ComponentFile>& files, Style style);
/// The same list as one JSON object: {"components": [{"file", "path", "interface", "text"}, ...]}.
std::string component_list_json(const std::vector<host::ComponentFile>& files);

/// Escapes a text for XML.
std::string escaped(const std::string& text);

}  // namespace takt::tool
