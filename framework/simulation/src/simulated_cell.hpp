// The cell as it is simulated. All its samples have the same size, and their bytes identify them.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::simulation {

struct SimulatedCell {
  model::Cell cell;
  model::CellPorts ports;  ///< the connected ports of every module
};

/// Replaces the type of each connected port by a sample of kSampleBytes. A port that is missing in `ports`,
/// which may be empty, becomes an output if a connection begins at it. Otherwise it becomes an input, or an
/// event port if its module is sporadic. If an output has a safe value, zeros replace this value. Each
/// connection that leaves its device gets its own topic, so that its samples can be lost and delayed
/// separately.
SimulatedCell simulated_cell(const model::Cell& cell, const model::CellPorts& ports);

}  // namespace takt::simulation
