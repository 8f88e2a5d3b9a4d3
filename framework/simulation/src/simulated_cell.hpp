// The cell as it is simulated: with samples of one size, which identify themselves.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::simulation {

struct SimulatedCell {
  model::Cell cell;
  model::CellPorts ports;  ///< the connected ports of every module
};

/// Replaces the type of each connected port by a sample of kSampleBytes. A port that is not known (`ports`
/// may be empty) is an event port of a sporadic module, else an input or output. An output that has a safe
/// value still has one, but its value is dropped. Each connection that leaves its device gets a topic of its
/// own, so that its samples can be lost and delayed separately.
SimulatedCell simulated_cell(const model::Cell& cell, const model::CellPorts& ports);

}  // namespace takt::simulation
