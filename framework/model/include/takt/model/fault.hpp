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

/// In the order of takt::FaultKind in the IDL, which explains each kind.
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
};
inline constexpr std::size_t kFaultKinds = static_cast<std::size_t>(FaultKind::not_real_time) + 1;
/// "missed-rows"; "?" for a value that is not a kind.
const char* to_text(FaultKind kind) noexcept;
/// All words of to_text().
std::vector<std::string_view> fault_words();
std::optional<FaultKind> fault_kind(std::string_view word) noexcept;

enum class Severity : std::uint32_t { note, warning, error };
const char* to_text(Severity severity) noexcept;
Severity severity_of(FaultKind kind) noexcept;

struct Fault {
  std::uint64_t sequence = 0;  ///< number of the event on the device, from 1; the fault record assigns it
  std::int64_t time_ns = 0;    ///< since 1970 (UTC)
  std::string cell{};          ///< "-": the device had no deployment
  std::string device{};
  std::string module{};  ///< empty: the event concerns the whole device
  FaultKind kind = FaultKind::error;
  std::string error{};       ///< for an error: "crash", "budget" ...
  std::string cause{};       ///< readable text
  std::string attachment{};  ///< path of a file on the device's machine with details; empty: none
  std::uint64_t count = 1;   ///< number of occurrences since the previous event of this kind
  std::uint64_t cycle = 0;   ///< of the module; 0: unknown
  bool operator==(const Fault&) const = default;
};

nlohmann::ordered_json to_json(const Fault& fault);
/// Reads an event from JSON. None if the value is not an event.
std::optional<Fault> fault_from(const nlohmann::ordered_json& value);

/// Selects events by device, module, kind, number and time.
struct FaultFilter {
  std::string device{};               ///< empty: all devices
  std::string module{};               ///< empty: all modules, and the events of the device itself
  std::vector<FaultKind> kinds{};     ///< empty: all kinds
  std::uint64_t after = 0;            ///< only events with a higher sequence number
  std::int64_t since_ns = 0;          ///< only events from this time on, in ns since 1970 (UTC)
  std::optional<std::size_t> last{};  ///< only the last N matching events; none: all of them

  /// Whether the event matches, regardless of `last`.
  [[nodiscard]] bool takes(const Fault& fault) const;
  /// The matching events, in the same order.
  [[nodiscard]] std::vector<Fault> of(const std::vector<Fault>& faults) const;
};
nlohmann::ordered_json to_json(const FaultFilter& filter);
/// Reads a filter from JSON. Fails if the text has a mistake, and names it. An empty text is a filter that
/// matches everything.
Result<FaultFilter> filter_from(std::string_view json);

/// Reads kinds from a list such as "error,overrun". If a word is unknown, fails with that word and the
/// possible ones.
Result<std::vector<FaultKind>> kinds_from(std::string_view list);

}  // namespace takt::model
