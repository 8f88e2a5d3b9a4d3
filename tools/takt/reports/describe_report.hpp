// What `takt describe` says of components: for a person, for a program, to paste into a descriptor, and as a
// module profile.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <takt/host/description.hpp>
#include <takt/host/inspect.hpp>
#include <takt/model/cell.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// A component, and, where a descriptor names it, the module that is made of it.
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

/// A <module> element of a descriptor, with the defaults. What has an event port is offered as sporadic and
/// released by it; what has a condition as sporadic; a program as what it calls; everything else as periodic.
std::string describe_xml(const Described& described);

/// A module profile in the terms of ISO 22166-202; docs/describe.md says which of its terms, and why no more.
/// `operation`: how it is released, where it is known.
std::string iso22166_profile(const Described& described, std::optional<model::Operation> operation);

/// How it is released, as far as that is known: by the descriptor, or by what the program calls.
std::optional<model::Operation> operation_of(const Described& described);

/// A line for each component, by its folder.
std::string component_list_text(const std::vector<host::ComponentFile>& files, Style style);
/// One object, {"components": [{"file", "path", "interface", "text"}, ...]}.
std::string component_list_json(const std::vector<host::ComponentFile>& files);

/// The text as XML has it.
std::string escaped(const std::string& text);

}  // namespace takt::tool
