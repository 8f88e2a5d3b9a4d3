// Evaluates the answers of devices.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/commands.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::client {

/// Returns the time of this machine's wall clock, in ns since 1970.
std::int64_t wall_ns();
/// Returns a random id of 16 hexadecimal digits.
std::string new_id();
/// Returns the problems, and adds the device's name to each problem that does not contain this name.
Problems of_device(const std::string& device, Problems problems);
/// Returns the ports of all modules of the cell, as the devices reported them in `replies`. The caller needs
/// these ports to check the connections between modules. Fails if a reply cannot be read.
Result<model::CellPorts> ports_of(const model::Cell& cell, const std::vector<wire::WholeReply>& replies);

}  // namespace takt::client
