// The report of `takt run --check-realtime` at the end of a run.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace takt::tool {

/// The `realtime_violations` of a status object as text: each with its count and the calls that led there, or
/// a line that there were none. Empty if nothing was checked. Ends with a line feed.
std::string violations_text(const nlohmann::ordered_json& status);

}  // namespace takt::tool
