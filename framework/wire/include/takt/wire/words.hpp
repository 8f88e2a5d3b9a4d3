// Texts for the enumerations of the wire format, and functions that fit texts into its bounded strings.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <takt/wire/takt.h>

namespace takt {

/// The name of a state as in reports, such as "IDLE". Here and below, an unknown enumerator gives "?".
const char* to_text(LifecycleState state) noexcept;
/// The name of an event, such as "initialize" or "give up"; "" for EVENT_NONE.
const char* to_text(LifecycleEvent event) noexcept;
/// The name of an error, such as "failure" or "budget"; "" for ERROR_NONE.
const char* to_text(LifecycleError error) noexcept;
/// The name of a device's state, such as "waiting" or "running".
const char* to_text(DeviceState state) noexcept;
/// The name of a device's health: "ok", "degraded" or "failed".
const char* to_text(DeviceHealth health) noexcept;
/// The name of a command, such as "start" or "undeploy".
const char* to_text(CommandKind kind) noexcept;

}  // namespace takt

namespace takt::wire {

/// Cuts the text to at most `bytes` bytes, without partial characters. "..." at the end marks a cut text.
std::string cut(std::string_view text, std::size_t bytes);

template <std::size_t N>
void set(eprosima::fastrtps::fixed_string<N>& field, std::string_view text) {
  field = cut(text, N);
}

/// Returns the key of a sample: "CELL/DEVICE", or "CELL/DEVICE/MODULE".
std::string path_of(std::string_view cell, std::string_view device, std::string_view part = {});
/// The cell name of a device without a deployment.
inline constexpr std::string_view kNoCell = "-";
/// A value of Command::property in COMMAND_PREPARE. With it, a device that cannot run in real time rejects
/// the command.
inline constexpr const char* kRequireRealTime = "require-realtime";
/// Reply::value after an update was put back, if the device is again as it was before the update.
inline constexpr const char* kAsBefore = "as before";

}  // namespace takt::wire
