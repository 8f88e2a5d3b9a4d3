// Texts for the enumerations of the wire format, and functions that shorten a text until it fits into a
// bounded string of the wire format.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <takt/wire/takt.h>

namespace takt {

/// The name of a module's state as printed in reports, such as "IDLE". This and the following functions
/// return "?" for an unknown enumerator.
const char* to_text(LifecycleState state) noexcept;
/// The name of a lifecycle event, such as "initialize" or "give up"; "" for EVENT_NONE.
const char* to_text(LifecycleEvent event) noexcept;
/// The name of a lifecycle error, such as "failure" or "budget"; "" for ERROR_NONE.
const char* to_text(LifecycleError error) noexcept;
/// The name of a device's state, such as "waiting" or "running".
const char* to_text(DeviceState state) noexcept;
/// The name of a device's health: "ok", "degraded" or "failed".
const char* to_text(DeviceHealth health) noexcept;
/// The name of a transaction's stage, such as "final".
const char* to_text(TransactionStage stage) noexcept;
/// The name of a command, such as "start" or "undeploy".
const char* to_text(CommandKind kind) noexcept;

}  // namespace takt

namespace takt::wire {

/// Truncates the text to at most `bytes` bytes, without splitting a UTF-8 character. A truncated text ends
/// with "...".
std::string cut(std::string_view text, std::size_t bytes);

/// Sets a bounded string of the wire format. Its namespace depends on the version of the code generator.
template <template <std::size_t> class FixedString, std::size_t N>
void set(FixedString<N>& field, std::string_view text) {
  field = cut(text, N);
}

/// Returns the key of a sample: "CELL/DEVICE" if `part` is empty, or "CELL/DEVICE/PART", where the part is
/// usually a module.
std::string path_of(std::string_view cell, std::string_view device, std::string_view part = {});
/// Used instead of the cell's name for a device without a deployment.
inline constexpr std::string_view kNoCell = "-";
/// The value of Command::value in a COMMAND_CHANGE that a device must reject if it cannot run in real
/// time.
inline constexpr const char* kRequireRealTime = "require-realtime";
/// The value of Reply::value after an undone update, if the device is exactly as it was before the update.
inline constexpr const char* kAsBefore = "as before";

/// The value of Reply::value if an update cannot be undone, because it is final.
inline constexpr const char* kKept = "kept";

/// The value of Reply::value if a step of an update fails, because the cell was undeployed meanwhile.
inline constexpr const char* kUndeployed = "undeployed";

/// Returns true if the device executes its deployment.
bool executes(const DeviceStatus& status);

/// The sentence that reports another node with the same device name, for example "another node named line is
/// on domain 7: process 42 on cell-pc". If that node executes a cell, the sentence also says for how long.
std::string name_conflict(const DeviceStatus& other, int domain);
/// The sentence that reports all nodes with one device name, for example "2 nodes on domain 7 have this name:
/// process 41 on line-pc, process 42 on cell-pc".
std::string nodes_of_one_name(const std::vector<DeviceStatus>& nodes, int domain);

}  // namespace takt::wire
