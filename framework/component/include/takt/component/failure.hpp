// What a hook that cannot return an error says instead, kept for the thread that called the hook.
#pragma once

#include <cstddef>
#include <string_view>

namespace takt {

inline constexpr std::size_t kFailureText = 256;

/// Called in a hook, by the thread that runs it. Real-time: copies at most kFailureText - 1 bytes.
void say_failure(std::string_view text) noexcept;
/// What the hook that just ended said on this thread, null when nothing; valid until this thread says
/// something again. Forgets it. Real-time.
const char* take_failure() noexcept;

}  // namespace takt
