// The failure that a hook reports if it cannot return an error, kept for the thread that called the hook.
#pragma once

#include <cstddef>
#include <string_view>

namespace takt {

inline constexpr std::size_t kFailureText = 256;

/// Reports a failure from a hook, on the thread that runs the hook. A later report replaces an earlier one.
/// Keeps at most kFailureText - 1 bytes. A real-time thread may call it.
void report_failure(std::string_view text) noexcept;
/// Returns the failure that the last hook reported on this thread, or null, and forgets it. The text is valid
/// until this thread reports again. A real-time thread may call it.
const char* take_failure() noexcept;

}  // namespace takt
