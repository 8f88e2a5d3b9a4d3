// Waits for a word in shared memory to change.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include <takt/core/time.hpp>

namespace takt::os {

/// Sleeps while `word` equals `expected`, until a futex_wake() with one of the bits of `mask`, or until
/// `deadline` (monotonic). It may also return early without a reason, so the caller must check the word
/// again. Works between processes. One system call.
void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, std::uint32_t mask,
                std::optional<Instant> deadline = std::nullopt) noexcept;

/// Wakes all threads that sleep on `word` with one of the bits of `mask`. One system call. Real-time threads
/// may call this.
void futex_wake(const std::atomic<std::uint32_t>& word, std::uint32_t mask) noexcept;

}  // namespace takt::os
