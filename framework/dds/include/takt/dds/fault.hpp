// An event of a fault record as it goes over the wire.
#pragma once

#include <takt/wire/takt.h>
#include <takt/model/fault.hpp>

namespace takt::dds {

/// What does not fit into a bounded text is cut off.
FaultEvent to_wire(const model::Fault& fault);
model::Fault from_wire(const FaultEvent& event);

}  // namespace takt::dds
