// The output of `takt describe`: components as text, as JSON, as XML for a descriptor, and as a module
// profile.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/host/description.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/cell.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// A component and, if a descriptor was given, a module that is made from it.
struct Described {
  std::string path;
  host::Description component;
  std::optional<std::string> cell{};  ///< of the module
  std::optional<std::string> device{};
  std::optional<model::Module> module{};
};

std::string describe_text(const Described& described, Style style);

/// The object of docs/describe.md, on one line.
std::string describe_json(const Described& described);

/// A <module> element for a descriptor, with the defaults. The operation type is that of the program, if
/// known. Otherwise a component with an event port or a condition is sporadic, and any other component is
/// periodic.
std::string describe_xml(const Described& described);

/// A module profile with the terms of ISO 22166-202; docs/describe.md lists the terms that are used, and why.
/// `operation`: how the module is released, if known.
std::string iso22166_profile(const Described& described, std::optional<model::Operation> operation);

/// How the module is released, if known from the descriptor or from the functions that the program calls.
std::optional<model::Operation> operation_of(const Described& described);

/// A line for each component, grouped by folder.
std::string component_list_text(const std::vector<host::ComponentFile>& files, Style style);
/// One object, {"components": [{"file", "path", "interface", "text"}, ...]}.
std::string component_list_json(const std::vector<host::ComponentFile>& files);

/// The text, escaped for XML.
std::string escaped(const std::string& text);

}  // namespace takt::tool
