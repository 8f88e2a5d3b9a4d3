// The rules for connections, services and discovery, which may concern several devices.
#pragma once

#include <takt/model/cell.hpp>
#include <takt/model/findings.hpp>
#include <takt/model/validate.hpp>

namespace takt::model {

/// Checks the rules for connections, services and discovery. validate() calls this function. `gaps.of_device`
/// must have an entry for every device.
void validate_network(const Cell& cell, const Gaps& gaps, Findings& findings);

}  // namespace takt::model
