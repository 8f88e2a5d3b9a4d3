// A mistake of ours, found at run time: the process ends and its supervisor acts. For what the world does
// wrong there is Result.
#pragma once

namespace takt {

/// Prints the condition and its place on standard error and aborts. Any thread may call it; it does not
/// return.
[[noreturn]] void check_failed(const char* condition, const char* file, int line) noexcept;

}  // namespace takt

/// Holds in every build, also in release.
#define TAKT_CHECK(condition) \
  (static_cast<bool>(condition) ? void(0) : ::takt::check_failed(#condition, __FILE__, __LINE__))
