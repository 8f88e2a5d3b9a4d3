// The properties of this program, and the values that its arguments give them. Part of libtakt_process.
#pragma once

#include <string>
#include <string_view>

#include <takt/core/result.hpp>

namespace takt {

/// Returns all problems of the properties and their arguments: a duplicate name, a default out of its range,
/// a rejected value, an argument that names no property. Empty for a program without properties.
Problems check_program_properties();

/// Returns the properties as JSON: a list of {"name", "type", "default", "range", "min", "max", "unit",
/// "text"}.
std::string program_properties_json();

/// Returns the text as a JSON string, in quotes.
std::string in_json(std::string_view text);

}  // namespace takt
