// The cell as it is simulated. All its samples have the same size, and their bytes identify them.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::simulation {

/// Numbers the connections of all descriptors of a simulation. Connections with the same ends have the same
/// number, so that a device can send to another one that has not been updated yet.
class ConnectionNumbers {
 public:
  /// Returns the number of each connection of a descriptor.
  std::vector<std::uint32_t> of(const model::Cell& cell);
  [[nodiscard]] std::size_t size() const noexcept { return known_.size(); }

 private:
  std::map<std::pair<std::string, std::string>, std::uint32_t> known_;  // by both ends
};

struct SimulatedCell {
  model::Cell cell;
  model::CellPorts ports;                ///< the connected ports of every module
  std::vector<std::uint32_t> numbers{};  ///< the number of each connection
};

/// Replaces the type of each connected port by a sample of kSampleBytes. A port that is missing in `ports`,
/// which may be empty, becomes an output if a connection begins at it. Otherwise it becomes an input, or an
/// event port if its module is sporadic. If an output has a safe value, zeros replace this value. Each
/// connection that leaves its device gets its own topic, so that its samples can be lost and delayed
/// separately.
SimulatedCell simulated_cell(const model::Cell& cell, const model::CellPorts& ports);

}  // namespace takt::simulation
