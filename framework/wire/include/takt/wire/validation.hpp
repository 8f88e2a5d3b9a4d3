// Validates samples received from the network. The generated decoder accepts any number as an enumerator and
// any bytes as a text. The sender may be a program of another version, or malicious.
#pragma once

#include <takt/wire/takt.h>

namespace takt::wire {

/// Returns false if an enumerator does not exist, or if a name is missing, is not UTF-8, or contains control
/// characters. In free texts, such as the reason of a failure, invalid bytes are replaced, because a damaged
/// text is better than none.
bool validate(LifecycleStatus& status) noexcept;
bool validate(DeviceStatus& status) noexcept;
bool validate(ModuleStatistics& statistics) noexcept;
bool validate(ExecutorStatistics& statistics) noexcept;
bool validate(PortStatus& status) noexcept;
bool validate(FaultEvent& event) noexcept;
/// Validates one part of a command or reply, including its part number.
bool validate(Command& command) noexcept;
bool validate(Reply& reply) noexcept;

}  // namespace takt::wire
