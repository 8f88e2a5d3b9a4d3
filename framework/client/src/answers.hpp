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
/// Returns the problems, each with the device's name added if it does not contain this name.
Problems of_device(const std::string& device, Problems problems);
/// Returns the ports of all modules of the cell, as the devices reported them in `replies`. The caller needs
/// these ports to check the connections between modules.
model::CellPorts ports_of(const model::Cell& cell, const std::vector<wire::WholeReply>& replies);

/// Sends keep-alives to devices. A device that receives nothing from this program for some seconds undoes
/// what it has prepared, because the program may have died. Keep-alives prevent this while the program waits
/// for a slower device.
class KeepAlive {
 public:
  /// Sends a keep-alive to each device if some seconds have passed since the last message to the devices. The
  /// keep-alive is a request for the device's report.
  void send(Operator& asker, const std::vector<std::string>& devices,
            const std::function<Question(CommandKind, const std::string& device)>& question);
  /// Records that the program is sending another message to all devices now, so that no keep-alive is due.
  void sent() noexcept { last_ = std::chrono::steady_clock::now(); }

 private:
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace takt::client
