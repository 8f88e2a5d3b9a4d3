// The file format of a profile. `takt run --profile` writes profiles; the analysis and the simulation read
// them.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/model/profile.hpp>

namespace takt::model {

/// Returns the text of a profile: `{"cell": str, "machine": {str: str}, "modules": {"device.module": {"runs":
/// n, "min_ns": n, "p50_ns": n, "p99_ns": n, "p999_ns": n, "max_ns": n}}}`, indented for people. `machine`
/// describes the machine that ran the modules, in free text. Ends with a line feed.
std::string profile_json(const Profile& profile, const std::map<std::string, std::string>& machine);

/// Converts the text of a profile. Fails if the text is not JSON, if members are missing or unknown, if a
/// time is not a whole number of at least 0, or if the times are not in ascending order. Reports all mistakes
/// at once, each at `FILE:LINE`. `file` is used only in messages.
Result<Profile> parse_profile(std::string_view text, std::string_view file);

}  // namespace takt::model
