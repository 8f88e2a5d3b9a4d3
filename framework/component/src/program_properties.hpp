// The properties of this program, and what its arguments say to them. Part of libtakt_process.
#pragma once

#include <string>
#include <string_view>

#include <takt/core/result.hpp>

namespace takt {

/// Everything that is wrong with the properties or with what they were given: a name that is none or is there
/// twice, a default out of its range, a value that was not taken, an argument that no property is named for.
/// Of a program without properties nothing is.
Problems check_program_properties();

/// A list of {"name", "type", "default", "range", "min", "max", "unit", "text"}, JSON.
std::string program_properties_json();

/// The text as JSON has it, in its "".
std::string in_json(std::string_view text);

}  // namespace takt
