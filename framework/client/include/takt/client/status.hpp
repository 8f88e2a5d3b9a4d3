// The status of every device of a domain, as the JSON that `takt status --json` prints.
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// Asks all devices in parallel and returns their status. A lost device has "alive": false and the module
/// states that other nodes received last. A device that other devices of its cell name, but that this program
/// does not find, has "alive": false and no modules. If two nodes have the same device name,
/// each node has its own object, with the member "conflict". If the devices of a cell do not all have the
/// same deployment, the member "differences" says so. Fails if no device is found.
Result<nlohmann::ordered_json> status(Operator& sender);

/// Returns one sentence for each cell whose live devices do not all have the same deployment and the same
/// last update. `devices` is the list of the devices' status; `cells` names the devices of each cell.
std::vector<std::string> differences(const nlohmann::ordered_json& devices,
                                     const std::map<std::string, std::set<std::string>>& cells);

}  // namespace takt::client
