// Makes a profile, which has the run times of modules, from the closing report of a cell.
#pragma once

#include <nlohmann/json.hpp>

#include <takt/model/profile.hpp>

namespace takt::tool {

/// Makes the profile from a status object, as `takt status --json` prints it. Its run times are in
/// microseconds. A device without a report contributes no modules. A module that never ran has 0 runs.
model::Profile profile_of(const nlohmann::ordered_json& status);

}  // namespace takt::tool
