// Texts for the enumerations of the wire format, and functions that fit texts into its bounded strings.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <takt/wire/takt.h>

namespace takt {

/// "IDLE", "EXECUTING", as in reports. Here and below, an unknown enumerator gives "?".
const char* to_text(LifecycleState state) noexcept;
/// "initialize", "give up"; "" for EVENT_NONE.
const char* to_text(LifecycleEvent event) noexcept;
/// "failure", "budget"; "" for ERROR_NONE.
const char* to_text(LifecycleError error) noexcept;
/// "waiting", "running".
const char* to_text(DeviceState state) noexcept;
/// "ok", "degraded", "failed".
const char* to_text(DeviceHealth health) noexcept;
/// "start", "undeploy".
const char* to_text(CommandKind kind) noexcept;

}  // namespace takt

namespace takt::wire {

/// At most `bytes` of the text, without partial characters; "..." marks an omission.
std::string cut(std::string_view text, std::size_t bytes);

template <std::size_t N>
void set(eprosima::fastrtps::fixed_string<N>& field, std::string_view text) {
  field = cut(text, N);
}

/// "CELL/DEVICE", "CELL/DEVICE/MODULE": the key of a topic.
std::string path_of(std::string_view cell, std::string_view device, std::string_view part = {});
/// The cell name of a device without a deployment.
inline constexpr std::string_view kNoCell = "-";
/// Command::property of COMMAND_PREPARE: the device rejects the command if it cannot run in real time.
inline constexpr const char* kRequireRealTime = "require-realtime";
/// Reply::value of an update that was put back, if the device is as it was before.
inline constexpr const char* kAsBefore = "as before";

}  // namespace takt::wire
