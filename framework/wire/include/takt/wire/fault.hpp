// Converts an event of a fault record to and from its wire format.
#pragma once

#include <takt/wire/takt.h>
#include <takt/model/fault.hpp>

namespace takt::wire {

/// Converts a fault event to its wire format. Texts that are too long for their fields are truncated.
FaultEvent to_wire(const model::Fault& fault);
model::Fault from_wire(const FaultEvent& event);

}  // namespace takt::wire
