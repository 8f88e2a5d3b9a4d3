// Evaluates the answers of all devices and sends keep-alives to them, for deploy() and update().
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/dds/commands.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::client {

/// The time of this machine's wall clock, in ns since 1970.
std::int64_t wall_ns();
/// Returns a random id of 16 hexadecimal digits.
std::string new_id();
/// Adds the device's name to each problem that does not mention it.
Problems of_device(const std::string& device, Problems problems);
/// The ports of all modules of the cell, as the devices reported them. With these ports, all connections of
/// the cell can be checked.
model::CellPorts ports_of(const model::Cell& cell, const std::vector<wire::WholeReply>& replies);

/// Sends keep-alives to devices. A device that receives nothing from this program for a while undoes what it
/// has prepared, because the program may have died. Keep-alives prevent this while another device takes long.
class KeepAlive {
 public:
  /// Asks each device for its report, if some seconds have passed since the last message to the devices.
  void send(Operator& asker, const std::vector<std::string>& devices,
            const std::function<Question(CommandKind, const std::string& device)>& question);
  /// Notes that a message to all devices is being sent now.
  void sent() noexcept { last_ = std::chrono::steady_clock::now(); }

 private:
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace takt::client
