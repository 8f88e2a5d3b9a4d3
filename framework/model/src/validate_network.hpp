// What a cell can be wrong about between its devices: its connections, and how its nodes find each other.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/findings.hpp>
#include <takt/model/validate.hpp>

namespace takt::model {

/// The part of validate() that is about more than one device. `gaps` knows of every device.
void validate_network(const Cell& cell, const Gaps& gaps, Findings& findings);

}  // namespace takt::model
