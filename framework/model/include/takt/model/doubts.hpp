// What is valid in a cell, but probably not what its author meant.
#pragma once

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/ports.hpp>

namespace takt::model {

/// Returns a warning, with `file:line` and a fix, for each of these:
/// - An event port has a connection that holds only the latest value, or a queue has no depth.
/// - An event port belongs to a periodic module, which no event releases.
/// - The values of a connection become stale before their periodic writer writes the next one.
/// - A budget or deadline of a module is below 10 us, so its unit was probably forgotten.
/// Skips connections whose ports are not known. The cell must be one that validate() accepts.
Problems doubts(const Cell& cell, const CellPorts& ports);

}  // namespace takt::model
