// Makes the report that `takt run --check-realtime` prints at the end of a run.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

namespace takt::tool {

/// Converts the member `realtime_violations` of a status object to text. Each violation has its count and the
/// calls that led to it. If there are no violations, the text is a line that says so. If the run was not
/// checked, the text is empty. Otherwise it ends with a line feed.
std::string violations_text(const nlohmann::ordered_json& status);

}  // namespace takt::tool
