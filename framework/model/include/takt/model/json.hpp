// Reads and writes JSON for all rooms. The JSON parser takes seconds to compile, so only this room compiles
// it. Not for real-time threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace takt::model {

/// Parses the text. If it is not JSON, the value is_discarded(); accessing a member of such a value throws
/// nlohmann::json::exception.
nlohmann::ordered_json parse_json(std::string_view text);
/// The value on one line. Bytes that are not UTF-8 are replaced by U+FFFD.
std::string json_text(const nlohmann::ordered_json& value);
/// None if the value is not a number, has a fraction, is negative or does not fit. get() would convert all of
/// these to some number; for a large number with a fraction the result is undefined.
std::optional<std::uint64_t> whole_number(const nlohmann::ordered_json& value);

}  // namespace takt::model
