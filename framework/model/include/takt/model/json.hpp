// Reads and writes JSON for the whole framework. Only json.cpp compiles the JSON parser, because compiling it
// takes seconds. Real-time threads must not use these functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace takt::model {

/// Parses the text. If the text is not JSON, is_discarded() of the result is true, and accessing a member of
/// the result throws nlohmann::json::exception.
nlohmann::ordered_json parse_json(std::string_view text);
/// Writes the value as one line. Replaces bytes that are not valid UTF-8 by U+FFFD, and escapes all control
/// characters (U+0085 becomes \u0085), so that the line may be printed on a terminal.
std::string json_text(const nlohmann::ordered_json& value);
/// Returns the value as a whole number; none if it is not a number, has a fraction, is negative or is too
/// large. In these cases, the value's get() would return a wrong number, or even have undefined behaviour.
std::optional<std::uint64_t> whole_number(const nlohmann::ordered_json& value);

}  // namespace takt::model
