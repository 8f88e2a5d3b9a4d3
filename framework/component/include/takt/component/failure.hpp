// Keeps, separately for each thread, the reports that a hook makes by a call instead of a return value: that
// the hook failed, or that the module has finished.
#pragma once

#include <cstddef>
#include <string_view>

namespace takt {

inline constexpr std::size_t kFailureText = 256;

/// Reports that the hook which runs on this thread failed. A later report replaces an earlier one. Keeps at
/// most kFailureText - 1 bytes of the text. A real-time thread may call it.
void report_failure(std::string_view text) noexcept;
/// Returns the failure that the last hook reported on this thread, and clears it. Returns null if there is
/// none. The text is valid until a hook on this thread reports the next failure. A real-time thread may call
/// it.
const char* take_failure() noexcept;

/// Reports from run() that the module has finished, on the thread that calls run(). A real-time thread may
/// call it.
void report_finished() noexcept;
/// Returns true if report_finished() was called on this thread since the last call of take_finished(). A
/// real-time thread may call it.
bool take_finished() noexcept;

}  // namespace takt
