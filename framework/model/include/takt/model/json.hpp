// Reads and writes JSON for the whole framework. Only this part of the framework compiles the JSON parser,
// because compiling it takes seconds. Real-time threads must not use these functions.
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
/// Writes the value as one line. Bytes that are not valid UTF-8 are replaced by U+FFFD.
std::string json_text(const nlohmann::ordered_json& value);
/// The value as a whole number. Returns none if the value is not a number, has a fraction, is negative or is
/// too large. In these cases get() would return an arbitrary number, or even have undefined behaviour for a
/// large number with a fraction.
std::optional<std::uint64_t> whole_number(const nlohmann::ordered_json& value);

}  // namespace takt::model
