// What `takt run --check-realtime` says when it ends.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace takt::tool {

/// The lists `realtime_violations` of a status object: each with how often it happened and the calls that led
/// there, or that there were none. Empty where nothing was checked. Ends with a line feed.
std::string violations_text(const nlohmann::ordered_json& status);

}  // namespace takt::tool
