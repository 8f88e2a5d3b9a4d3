// Waiting for a word in shared memory to change.
#pragma once

#include <atomic>
#include <cstdint>
#include <optional>

#include <takt/core/time.hpp>

namespace takt::os {

/// Sleeps while `word` is `expected`, until somebody wakes one of the bits in `mask`, until `deadline`
/// (monotonic), or for no reason at all: check the word again. Works between processes. One system call.
void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, std::uint32_t mask,
                std::optional<Instant> deadline = std::nullopt) noexcept;

/// Wakes everybody who sleeps on `word` with one of the bits in `mask`. One system call; a real-time thread
/// may.
void futex_wake(const std::atomic<std::uint32_t>& word, std::uint32_t mask) noexcept;

}  // namespace takt::os
