#include <takt/os/clock.hpp>

#include <cerrno>

namespace takt::os {

void sleep_until(Instant instant) noexcept {
  const std::int64_t ns = to_ns(instant);
  if (ns <= 0) return;
  const timespec t{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace takt::os
