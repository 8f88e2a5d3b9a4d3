#include <takt/os/futex.hpp>

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <climits>
#include <ctime>

namespace takt::os {

static_assert(sizeof(std::atomic<std::uint32_t>) == sizeof(std::uint32_t));

void futex_wait(const std::atomic<std::uint32_t>& word, std::uint32_t expected, std::uint32_t mask,
                std::optional<Instant> deadline) noexcept {
  timespec time{};
  if (deadline) {
    const std::int64_t ns = to_ns(*deadline);
    time = {.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
  }
  ::syscall(SYS_futex, &word, FUTEX_WAIT_BITSET, expected, deadline ? &time : nullptr, nullptr, mask);
}

void futex_wake(const std::atomic<std::uint32_t>& word, std::uint32_t mask) noexcept {
  ::syscall(SYS_futex, &word, FUTEX_WAKE_BITSET, INT_MAX, nullptr, nullptr, mask);
}

}  // namespace takt::os
