#include <takt/os/clock.hpp>

#include <cerrno>

namespace takt::os {

std::int64_t wall_ns() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_REALTIME, &t);
  return static_cast<std::int64_t>(t.tv_sec) * 1'000'000'000 + t.tv_nsec;
}

Instant instant_of_wall(std::int64_t wall) noexcept {
  // The system may preempt the thread for milliseconds between the readings of the two clocks. So read
  // several pairs, and use the pair whose readings are closest in time.
  constexpr int kPairs = 20;
  Nanoseconds closest = Nanoseconds::max();
  Nanoseconds offset{};
  for (int i = 0; i < kPairs; ++i) {
    const Instant before = now();
    const std::int64_t shown = wall_ns();
    const Nanoseconds apart = now() - before;
    if (apart >= closest) continue;
    closest = apart;
    offset = before.time_since_epoch() + apart / 2 - Nanoseconds{shown};
  }
  return Instant{offset + Nanoseconds{wall}};
}

void sleep_until(Instant instant) noexcept {
  const std::int64_t ns = to_ns(instant);
  if (ns <= 0) return;
  const timespec t{.tv_sec = ns / 1'000'000'000, .tv_nsec = ns % 1'000'000'000};
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) == EINTR) {
  }
}

}  // namespace takt::os
