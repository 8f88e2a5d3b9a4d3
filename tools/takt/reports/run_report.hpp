// Makes the closing report of `takt run`, which is also the output of `takt status`.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace takt::tool {

/// Converts a status object to tables with one line per executor and per module. They are at most 100 columns
/// wide if names have at most 20 characters. Times are in microseconds. The text ends with a line feed.
std::string run_text(const nlohmann::ordered_json& status);
/// Converts a status object to JSON, without the margins of the executors, which only the tables show. The
/// text ends with a line feed.
std::string run_json(nlohmann::ordered_json status);

}  // namespace takt::tool
