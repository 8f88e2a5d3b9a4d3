// TAKT_CHECK, for programming errors in Takt that are found at run time: the process ends and its supervisor
// acts. For errors that come from outside use Result.
#pragma once

namespace takt {

/// Prints the condition with its file and line on standard error, and aborts. Any thread may call it.
[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace takt

/// Ends the process if the condition is false. Active in every build, including release.
#define TAKT_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::takt::check_failed(#condition, __FILE__, __LINE__))
