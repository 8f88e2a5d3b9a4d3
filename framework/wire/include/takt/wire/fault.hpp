// Converts an event of a fault record to and from its wire format.
#pragma once

#include <takt/wire/takt.h>
#include <takt/model/fault.hpp>

namespace takt::wire {

/// Converts a fault event for the network. Texts that are too long are cut off.
FaultEvent to_wire(const model::Fault& fault);
model::Fault from_wire(const FaultEvent& event);

}  // namespace takt::wire
