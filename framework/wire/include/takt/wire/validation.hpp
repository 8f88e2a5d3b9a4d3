// Validates samples received from the network. The generated decoder accepts any number as an enumerator and
// any bytes as a text. The sender may be a program of another version, or malicious.
#pragma once

#include <string_view>

#include <takt/wire/takt.h>

namespace takt::wire {

/// Returns true if the text is valid UTF-8 without control characters.
bool is_name(std::string_view text) noexcept;

/// Returns false if an enumerator does not exist, or if a name is missing, is not UTF-8, or contains control
/// characters. In free texts, such as the reason of a failure, replaces invalid bytes, because a damaged text
/// is better than no text.
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
