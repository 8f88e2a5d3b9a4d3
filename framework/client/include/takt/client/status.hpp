// How every device of a domain stands, as the contract's JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// Asks every device that there is, at once. One that is lost has the states that were last heard of its
/// modules, from whoever was there to hear them, and "alive": false; so has one, without modules, that others
/// of its cell know and that is not found from here within `limit`. Fails where no device is found within
/// `limit`.
Result<nlohmann::ordered_json> status(Operator& asker, Nanoseconds limit = std::chrono::seconds{3});

}  // namespace takt::client
