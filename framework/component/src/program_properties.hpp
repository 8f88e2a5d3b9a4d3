// The properties of this program, the values that its arguments give them, and the values that an operator
// sets while the program runs. Part of libtakt_process.
#pragma once

#include <string>
#include <string_view>

#include <takt/channel/release_slot.hpp>
#include <takt/core/result.hpp>

namespace takt {

/// Returns all problems of the properties and their arguments: a duplicate name, a default out of its range,
/// a rejected value, an argument that names no property. Empty for a program without properties.
Problems check_program_properties();

/// Returns the properties as JSON: a list of {"name", "type", "default", "range", "min", "max", "unit",
/// "text"}.
std::string program_properties_json();

/// Starts a thread that answers the node's requests to get and set the properties, until the program ends or
/// destroys a property. Without properties, starts nothing. Call it once. Not for real-time threads.
Result<void> serve_program_properties(channel::ReleaseSlot& slot);

/// Makes the values current that were set since the last call. The thread that runs the body calls it between
/// two bodies. A real-time thread may call it.
void take_over_program_properties() noexcept;

/// Returns the text as a JSON string, in quotes.
std::string in_json(std::string_view text);

}  // namespace takt
