// An event of a device's fault record: what went wrong on it, or what was done about that.
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

/// In the order of the wire's takt::FaultKind, where each is explained.
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
/// "missed-rows"; "?" for what is none.
const char* to_text(FaultKind kind) noexcept;
/// Every word of to_text().
std::vector<std::string_view> fault_words();
std::optional<FaultKind> fault_kind(std::string_view word) noexcept;

enum class Severity : std::uint32_t { note, warning, error };
const char* to_text(Severity severity) noexcept;
Severity severity_of(FaultKind kind) noexcept;

struct Fault {
  std::uint64_t sequence = 0;  ///< of the device's events, from 1; given by its record
  std::int64_t time_ns = 0;    ///< since 1970 (UTC)
  std::string cell{};          ///< "-": the device had no deployment
  std::string device{};
  std::string module{};  ///< empty: it is about the whole device
  FaultKind kind = FaultKind::error;
  std::string error{};       ///< of an error: "crash", "budget" ...
  std::string cause{};       ///< in words
  std::string attachment{};  ///< a file on the device's machine that says more; empty: none
  std::uint64_t count = 1;   ///< how often it happened since the event of this kind before it
  std::uint64_t cycle = 0;   ///< of the module; 0: it has none
  bool operator==(const Fault&) const = default;
};

nlohmann::ordered_json to_json(const Fault& fault);
/// None where it is no event.
std::optional<Fault> fault_from(const nlohmann::ordered_json& value);

/// Which events somebody wants to see.
struct FaultFilter {
  std::string device{};               ///< empty: of all
  std::string module{};               ///< empty: of all, and those of the device
  std::vector<FaultKind> kinds{};     ///< empty: all
  std::uint64_t after = 0;            ///< with a higher number only
  std::int64_t since_ns = 0;          ///< not older
  std::optional<std::size_t> last{};  ///< the newest so many of those that the rest takes; none: all

  /// Without `last`.
  [[nodiscard]] bool takes(const Fault& fault) const;
  /// Those that it takes, in their order.
  [[nodiscard]] std::vector<Fault> of(const std::vector<Fault>& faults) const;
};
nlohmann::ordered_json to_json(const FaultFilter& filter);
/// Fails with what is wrong in it. An empty text is a filter that takes all.
Result<FaultFilter> filter_from(std::string_view json);

/// "error,overrun" as kinds; fails with the word that is none, and what it may be.
Result<std::vector<FaultKind>> kinds_from(std::string_view list);

}  // namespace takt::model
