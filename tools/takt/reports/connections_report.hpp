// What check and graph tell alike: connections, how modules are released, how nodes find each other.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include <takt/model/cell.hpp>

#include "reports/page.hpp"

namespace takt::tool {

/// "robot.servo.setpoint"; "other programs" for an end that is not Takt's.
std::string end_text(const model::Endpoint& end);

/// "latest", "queue of 8"; "requests" and "replies" of a service.
std::string kind_text(const model::Connection& connection);

/// "queue of 8, reliable, deadline 20 ms, error when stale, lifespan 1 s, topic rt/x in domain 3".
std::string described(const model::Connection& connection);

/// Whether it has something to do with other devices or programs, or says that it may.
bool is_on_network(const model::Cell& cell);
/// "domain 7, discovery by multicast"
std::string network_text(const model::Cell& cell);

/// "periodic, every 1 ms", "sporadic, deadline 10 ms, at once, not before 1 ms"; how it is released.
std::string operation_text(const model::Module& module);

/// A table, a line a connection; where that is too wide, two. The first kConnectionRows, and how many more.
/// Names those that are stale between two writes of their writer. `states` are what is to be said of some of
/// them besides, by their index. Nothing where there are no connections.
void connections_text(Page& page, const model::Cell& cell,
                      const std::map<std::size_t, std::string>& states = {});
inline constexpr std::size_t kConnectionRows = 100;

}  // namespace takt::tool
