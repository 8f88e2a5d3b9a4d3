// JSON as every room reads and writes it. To compile its reader takes seconds each time, so that is done
// once. Not for real-time threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

namespace takt::model {

/// The text as a value; one that is_discarded() where it is no JSON: to take a member of that throws
/// nlohmann::json::exception.
nlohmann::ordered_json parse_json(std::string_view text);
/// In one line. What is no UTF-8 is in it as U+FFFD.
std::string json_text(const nlohmann::ordered_json& value);
/// None for what is no number, has a fraction, is less than 0 or larger than there is room for: get() makes
/// some number of all of these, and of a large one with a fraction nobody knows which.
std::optional<std::uint64_t> whole_number(const nlohmann::ordered_json& value);

}  // namespace takt::model
