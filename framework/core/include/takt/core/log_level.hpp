// The levels of log lines, and the name of the property that sets the log level of a module.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include <takt/core/result.hpp>

namespace takt {

/// How important a log line is. A module logs only lines that are at least as important as its log level, by
/// default `info`. `takt set DEVICE.MODULE log-level debug` changes the log level.
enum class LogLevel : std::uint8_t {
  error = 1,    ///< something failed
  warning = 2,  ///< something is not as it should be
  info = 3,     ///< an event of normal operation
  debug = 4,    ///< details for the author
};
/// The log level of a module for which no other level is set.
inline constexpr LogLevel kDefaultLogLevel = LogLevel::info;
/// Returns "error", "warning", "info" or "debug".
constexpr const char* to_text(LogLevel level) noexcept {
  constexpr const char* kTexts[] = {"error", "warning", "info", "debug"};
  const auto index = static_cast<std::size_t>(level) - 1;
  return index < 4 ? kTexts[index] : "?";
}

/// The name of the property that sets the log level of a module. Takt handles this property: the module does
/// not receive it, and a component must not declare a property of this name.
inline constexpr const char* kLogLevelProperty = "log-level";
/// Returns the level with this name. Fails if no level has the name; the problem then names the property.
/// Real-time threads must not call it.
Result<LogLevel> log_level_from(std::string_view name);

}  // namespace takt
