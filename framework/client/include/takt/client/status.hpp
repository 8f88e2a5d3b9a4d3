// The status of every device of a domain, as the JSON that `takt status --json` prints.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// Asks all devices in parallel and returns their status. A lost device has "alive": false and the module
/// states that other nodes last received. A device that other devices of its cell name, but that is not found
/// within `limit`, has "alive": false and no modules. Fails if no device is found within `limit`.
Result<nlohmann::ordered_json> status(Operator& asker, Nanoseconds limit = std::chrono::seconds{3});

}  // namespace takt::client
