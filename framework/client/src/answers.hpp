// Shared by deploy() and update(): evaluates the answers of all devices, and sends them keep-alives.
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

/// The wall clock of this machine, ns since 1970.
std::int64_t wall_ns();
/// A random id of 16 hexadecimal digits.
std::string new_id();
/// Adds the device's name to each problem that does not mention it.
Problems of_device(const std::string& device, Problems problems);
/// The ports of all modules of the cell, as the devices reported them. The connections of the whole cell can
/// then be checked against them.
model::CellPorts ports_of(const model::Cell& cell, const std::vector<wire::WholeReply>& replies);

/// A device undoes what it has prepared if it receives nothing from this program for a while, because the
/// program may have died. Keep-alives prevent that while another device takes long.
class KeepAlive {
 public:
  /// Asks each device for its report, if the last message to the devices was some seconds ago.
  void send(Operator& asker, const std::vector<std::string>& devices,
            const std::function<Question(CommandKind, const std::string& device)>& question);
  /// A message to all devices is being sent now.
  void sent() noexcept { last_ = std::chrono::steady_clock::now(); }

 private:
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace takt::client
