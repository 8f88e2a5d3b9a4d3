// The run times of a cell, from what its devices said when they ended.
#pragma once

#include <nlohmann/json.hpp>

#include <takt/model/profile.hpp>

namespace takt::tool {

/// Of the status object of the contract, whose run times are microseconds. A module of a device that said
/// nothing is left out; one that never ran has 0 runs.
model::Profile profile_of(const nlohmann::ordered_json& status);

}  // namespace takt::tool
