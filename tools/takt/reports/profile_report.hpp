// Makes a profile (run times) from the closing report of a cell.
#pragma once

#include <nlohmann/json.hpp>

#include <takt/model/profile.hpp>

namespace takt::tool {

/// The profile from a status object (as printed by `takt status --json`), whose run times are in
/// microseconds. A device without a report contributes no modules; a module that never ran has 0 runs.
model::Profile profile_of(const nlohmann::ordered_json& status);

}  // namespace takt::tool
