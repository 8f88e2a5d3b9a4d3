// The closing report of `takt run` and the output of `takt status`.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace takt::tool {

/// A status object as tables with one line per executor and per module, at most 100 columns wide for names of
/// up to 20 characters. Times in microseconds. Ends with a line feed.
std::string run_text(const nlohmann::ordered_json& status);
/// A status object as JSON, without the margins of the executors, which are only for the tables. Ends with a
/// line feed.
std::string run_json(nlohmann::ordered_json status);

}  // namespace takt::tool
