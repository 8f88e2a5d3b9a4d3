// The file of a profile: what `takt run --profile` writes, and what proves or simulates a cell reads.
#pragma once

#include <map>
#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/model/profile.hpp>

namespace takt::model {

/// `{"cell": str, "machine": {str: str}, "modules": {"device.module": {"runs": n, "min_ns": n, "p50_ns": n,
/// "p99_ns": n, "p999_ns": n, "max_ns": n}}}`, to be read by people too. `machine` says where it was
/// measured, in any words. Ends with a line feed.
std::string profile_json(const Profile& profile, const std::map<std::string, std::string>& machine);

/// Fails with every mistake at once: a text that is no JSON, what is missing, what does not belong there, a
/// time that is no whole number from 0 on, times that are out of order. Problems are at `FILE:LINE`. `file`
/// is for messages only.
Result<Profile> parse_profile(std::string_view text, std::string_view file);

}  // namespace takt::model
