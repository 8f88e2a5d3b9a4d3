// Waits for a word in shared memory to change.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include <takt/core/time.hpp>

namespace takt::os {

/// Sleeps while `word` equals `expected`, until `deadline` (monotonic), or until a thread calls futex_wake()
/// with a mask that has a common bit with `mask`. The function may also return for no reason, so the caller
/// must check the word afterwards. Works between processes. Makes one system call.
void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, std::uint32_t mask,
                std::optional<Instant> deadline = std::nullopt) noexcept;

/// Wakes all threads that sleep on `word` and whose mask has a common bit with `mask`. Makes one system call.
/// Real-time threads may call this.
void futex_wake(const std::atomic<std::uint32_t>& word, std::uint32_t mask) noexcept;

}  // namespace takt::os
