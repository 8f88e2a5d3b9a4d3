// TAKT_CHECK detects programming errors in Takt at run time: it aborts the process if a condition is false.
// The supervisor of the process handles the abort like a crash. For errors with a cause outside Takt's code,
// use Result.
#pragma once

namespace takt {

/// Prints the false condition with its file and line to standard error, and aborts the process. Any thread
/// may call this.
[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace takt

/// Aborts the process if the condition is false. Active in every build, including release builds.
#define TAKT_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::takt::check_failed(#condition, __FILE__, __LINE__))
