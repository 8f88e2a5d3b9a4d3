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

/// Returns the time of this machine's wall clock, in ns since 1970.
std::int64_t wall_ns();
/// Returns a random id of 16 hexadecimal digits.
std::string new_id();
/// Returns the problems, and adds the device's name to each problem that does not contain this name.
Problems of_device(const std::string& device, Problems problems);
/// Returns the ports of all modules of the cell, as the devices reported them in `replies`. The caller needs
/// these ports to check the connections between modules. Fails if a reply cannot be read.
Result<model::CellPorts> ports_of(const model::Cell& cell, const std::vector<wire::WholeReply>& replies);

/// Sends keep-alives to devices. If a device receives nothing from this program for some seconds, the device
/// undoes everything that it has prepared, because the program may have died. Keep-alives prevent this while
/// the program waits for a slower device.
class KeepAlive {
 public:
  /// Sends a keep-alive to each device if some seconds have passed since the last message to the devices. The
  /// keep-alive is a request for the device's report.
  void send(Operator& sender, const std::vector<std::string>& devices,
            const std::function<CommandRequest(CommandKind, const std::string& device)>& request);
  /// Records that the program is now sending a command to all devices, so that no keep-alive is due.
  void sent() noexcept { last_ = std::chrono::steady_clock::now(); }

 private:
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace takt::client
