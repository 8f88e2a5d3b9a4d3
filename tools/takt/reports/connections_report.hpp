// Makes texts for both `takt check` and `takt graph`: about connections, the release of modules, and the
// discovery of nodes.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include <takt/model/cell.hpp>

#include "reports/page.hpp"

namespace takt::tool {

/// The name of a connection's end: "robot.servo.setpoint", or "other programs" if the end is outside Takt.
std::string end_text(const model::Endpoint& end);

/// The kind of a connection: "latest" or "queue of 8"; for the connections of a service, "requests" or
/// "replies".
std::string kind_text(const model::Connection& connection);

/// All settings of a connection: "queue of 8, reliable, deadline 20 ms, error when stale, lifespan 1 s, topic
/// rt/x in domain 3".
std::string described(const model::Connection& connection);

/// True if the cell communicates over the network, or its descriptor has network settings.
bool is_on_network(const model::Cell& cell);
/// The network settings of a cell: "domain 7, discovery by multicast".
std::string network_text(const model::Cell& cell);

/// How a module is released: "periodic, every 1 ms" or
/// "sporadic, deadline 10 ms, immediate, interarrival 1 ms".
std::string operation_text(const model::Module& module);

/// Adds a table with one line per connection, or, if the table would be too wide, a list with two lines per
/// connection. Shows the first kConnectionRows connections and counts the rest. Warns of inputs that become
/// stale between two writes, and of readers that never get the safe value. `states` has additional texts for
/// some connections, by the index of the connection. Adds nothing if the cell has no connections.
void connections_text(Page& page, const model::Cell& cell,
                      const std::map<std::size_t, std::string>& states = {});
inline constexpr std::size_t kConnectionRows = 100;

}  // namespace takt::tool
