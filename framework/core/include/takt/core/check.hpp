// TAKT_CHECK detects programming errors in Takt at run time. It ends the process, and the supervisor of the
// process reacts to that. For errors that come from outside, use Result.
#pragma once

namespace takt {

/// Prints the condition with its file and line to standard error, and aborts the process. Any thread may call
/// this.
[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace takt

/// Ends the process if the condition is false. Active in every build, including release.
#define TAKT_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::takt::check_failed(#condition, __FILE__, __LINE__))
