// What the answers of all devices of a cell are together. Used by deploy.cpp and update.cpp.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/dds/commands.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::client {

/// Of the clock of this machine.
std::int64_t wall_ns();
/// One that nobody else has.
std::string new_id();
/// Problems that a device gave, with its name where they do not say it.
Problems of_device(const std::string& device, Problems problems);
/// What each device said of the ports of its modules: together they can be held against the connections.
model::CellPorts ports_of(const model::Cell& cell, const std::vector<dds::WholeReply>& replies);

}  // namespace takt::client
