// Whether what came over the wire can be what it says. The decoder takes any number for an enumerator and any
// bytes for a text; who sent it may be a program of another version, or mean harm.
#pragma once

#include <takt/wire/takt.h>

namespace takt::dds {

/// False where an enumerator does not exist, a name is missing or is not UTF-8 without control characters.
/// In free texts such bytes are replaced, because a reason in odd letters is better than none.
bool validate(LifecycleStatus& status) noexcept;
bool validate(DeviceStatus& status) noexcept;
bool validate(ModuleStatistics& statistics) noexcept;
bool validate(ExecutorStatistics& statistics) noexcept;
bool validate(PortStatus& status) noexcept;
bool validate(FaultEvent& event) noexcept;
/// Of one part of it: also that there is such a part.
bool validate(Command& command) noexcept;
bool validate(Reply& reply) noexcept;

}  // namespace takt::dds
