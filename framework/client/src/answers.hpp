// What deploying a cell and updating it share: the answers of all devices together, and being heard by them.
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

/// Of the clock of this machine.
std::int64_t wall_ns();
/// One that nobody else has.
std::string new_id();
/// Problems that a device gave, with its name where they do not say it.
Problems of_device(const std::string& device, Problems problems);
/// What each device said of the ports of its modules: together they can be held against the connections.
model::CellPorts ports_of(const model::Cell& cell, const std::vector<dds::WholeReply>& replies);

/// A device that holds something for us undoes it when it hears nothing for a while, as when we have died.
/// While others take longer than that it is told that we live.
class SignOfLife {
 public:
  /// Asks each for its report, where the last time that they heard us was some seconds ago.
  void give(Operator& asker, const std::vector<std::string>& devices,
            const std::function<Question(CommandKind, const std::string& device)>& question);
  /// They hear us at this moment.
  void given() noexcept { last_ = std::chrono::steady_clock::now(); }

 private:
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace takt::client
