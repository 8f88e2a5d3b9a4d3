// Texts that `takt check` and `takt graph` share: connections, how modules are released, how nodes discover
// each other.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include <takt/model/cell.hpp>

#include "reports/page.hpp"

namespace takt::tool {

/// "robot.servo.setpoint"; "other programs" for an end outside Takt.
std::string end_text(const model::Endpoint& end);

/// "latest" or "queue of 8"; for a service "requests" or "replies".
std::string kind_text(const model::Connection& connection);

/// "queue of 8, reliable, deadline 20 ms, error when stale, lifespan 1 s, topic rt/x in domain 3".
std::string described(const model::Connection& connection);

/// Whether the cell communicates over the network, or its descriptor has network settings.
bool is_on_network(const model::Cell& cell);
/// "domain 7, discovery by multicast"
std::string network_text(const model::Cell& cell);

/// How a module is released: "periodic, every 1 ms" or
/// "sporadic, deadline 10 ms, immediate, interarrival 1 ms".
std::string operation_text(const model::Module& module);

/// Adds a table with one line per connection, or a list with two lines each if the table is too wide. Shows
/// the first kConnectionRows and counts the rest. Warns of inputs that become stale between two writes, and
/// of inputs that do not get a safe value. `states`: an additional text for some connections, by index. Adds
/// nothing if the cell has no connections.
void connections_text(Page& page, const model::Cell& cell,
                      const std::map<std::size_t, std::string>& states = {});
inline constexpr std::size_t kConnectionRows = 100;

}  // namespace takt::tool
