// The report of `takt run --check-realtime` at the end of a run.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace takt::tool {

/// The `realtime_violations` of a status object as text. Each violation has its count and the calls that led
/// there. Without violations, the text is a line that says so. It is empty if nothing was checked. Ends with
/// a line feed.
std::string violations_text(const nlohmann::ordered_json& status);

}  // namespace takt::tool
