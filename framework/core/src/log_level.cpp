#include <takt/core/log_level.hpp>

#include <string>

#include <takt/core/words.hpp>

namespace takt {

Result<LogLevel> log_level_from(std::string_view name) {
  for (const LogLevel level : {LogLevel::error, LogLevel::warning, LogLevel::info, LogLevel::debug}) {
    if (name == to_text(level)) return level;
  }
  return fail("property '" + std::string{kLogLevelProperty} + "' cannot be " + in_quotes(name),
              suggestion(name, {"error", "warning", "info", "debug"}));
}

}  // namespace takt
