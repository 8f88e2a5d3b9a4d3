// An event of a device's fault record: something that went wrong on the device, or a reaction to it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <takt/core/result.hpp>

namespace takt::model {

/// The kinds of events, in the order of takt::FaultKind in the IDL, which explains each kind.
enum class FaultKind : std::uint32_t {
  error,
  recovered,
  not_recovered,
  given_up,
  overrun,
  missed_rows,
  stale_input,
  fresh_input,
  connection_lost,
  connection_back,
  device_lost,
  device_back,
  clocks_differ,
  clocks_agree,
  host_restart,
  program_restart,
  node_start,
  node_restart,
  node_end,
  device_failed,
  deployed,
  undeployed,
  command,
  refused_command,
  failed_command,
  refused_packet,
  refused_authentication,
  not_real_time,
  dropped_samples,
  log_error,
  log_warning,
  log_info,
  log_debug,
  forced,
  force_ended,
  acknowledged,
};
inline constexpr std::size_t kFaultKinds = static_cast<std::size_t>(FaultKind::acknowledged) + 1;
/// Returns the word for a kind, for example "missed-rows"; "?" for an invalid value.
const char* to_text(FaultKind kind) noexcept;
/// Returns the words of all kinds.
std::vector<std::string_view> fault_words();
std::optional<FaultKind> fault_kind(std::string_view word) noexcept;

enum class Severity : std::uint32_t { note, warning, error };
const char* to_text(Severity severity) noexcept;
Severity severity_of(FaultKind kind) noexcept;
/// True if events of this kind are log lines of modules.
bool is_log_line(FaultKind kind) noexcept;

struct Fault {
  std::uint64_t sequence = 0;  ///< number of the event on the device, from 1; the fault record assigns it
  std::int64_t time_ns = 0;    ///< time of the event, in nanoseconds since 1970 (UTC)
  std::string cell{};          ///< name of the cell; "-" if the device had no deployment
  std::string device{};
  std::string module{};  ///< name of the module; empty if the event concerns the whole device
  FaultKind kind = FaultKind::error;
  std::string error{};       ///< for an error: its kind, for example "crash" or "budget"; otherwise empty
  std::string cause{};       ///< readable text that explains the event
  std::string attachment{};  ///< path of a file on the device's machine with details; empty if there is none
  std::uint64_t count = 1;   ///< number of occurrences that this event stands for
  /// For a log line: the number of the release in which the module logged it (Cycle::number). For any other
  /// event of a module: how many cycles the module had executed. 0 if there is none.
  std::uint64_t cycle = 0;
  bool operator==(const Fault&) const = default;
};

nlohmann::ordered_json to_json(const Fault& fault);
/// Converts JSON to an event. Returns none if the value is not an event.
std::optional<Fault> fault_from(const nlohmann::ordered_json& value);

/// Selects events by device, module, kind, number and time.
struct FaultFilter {
  std::string device{};               ///< empty: all devices
  std::string module{};               ///< empty: all modules, and events that concern the whole device
  std::vector<FaultKind> kinds{};     ///< empty: all kinds
  std::uint64_t after = 0;            ///< only events with a higher sequence number
  std::int64_t since_ns = 0;          ///< only events from this time on, in ns since 1970 (UTC)
  std::optional<std::size_t> last{};  ///< only the last N matching events; none: all of them

  /// Returns true if the event matches this filter. Ignores `last`.
  [[nodiscard]] bool takes(const Fault& fault) const;
  /// Returns the events that match, in the same order, and only the last `last` of them.
  [[nodiscard]] std::vector<Fault> of(const std::vector<Fault>& faults) const;
};
nlohmann::ordered_json to_json(const FaultFilter& filter);
/// Converts JSON to a filter. An empty text becomes a filter that matches every event. Fails if the text is
/// not a filter; the problem names the mistake.
Result<FaultFilter> filter_from(std::string_view json);

/// Converts a list such as "error,overrun" to kinds. Fails if a word is unknown; the problem names this word
/// and possible kinds.
Result<std::vector<FaultKind>> kinds_from(std::string_view list);

}  // namespace takt::model
