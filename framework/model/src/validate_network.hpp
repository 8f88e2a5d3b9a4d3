// The rules of a cell that concern more than one device: its connections, its services and its discovery.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/findings.hpp>
#include <takt/model/validate.hpp>

namespace takt::model {

/// The part of validate() for these rules. `gaps.of_device` must have an entry for every device.
void validate_network(const Cell& cell, const Gaps& gaps, Findings& findings);

}  // namespace takt::model
