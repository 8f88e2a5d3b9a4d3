#include <takt/os/waker.hpp>

#include <algorithm>

#include <takt/os/clock.hpp>

namespace takt::os {

namespace {
// One step up for a delay beyond the margin weighs as much as 99 steps down: the margin settles where one wake-up in a
// hundred is later.
constexpr std::int64_t kUp = 990;
constexpr std::int64_t kDown = 10;
constexpr std::int64_t kLeast = 1'000;
}  // namespace

void WakeMargin::observe(Nanoseconds delay) noexcept {
  margin_ns_ += delay.count() > margin_ns_ ? kUp : -kDown;
  margin_ns_ = std::clamp(margin_ns_, std::min(kLeast, cap_ns_), cap_ns_);
}

Nanoseconds margin_cap(Nanoseconds period) noexcept {
  return std::min<Nanoseconds>(period * 2 / 5, std::chrono::microseconds{100});
}

Instant Waker::wait_until(Instant release) noexcept {
  Instant time = os::now();
  if (time >= release) return time;
  if (strategy_ != model::Wakeup::spin) {
    const Instant wake = release - margin_.value();
    if (time < wake) {
      sleep_until(wake);
      time = os::now();
      if (strategy_ == model::Wakeup::hybrid) margin_.observe(time - wake);
    }
  }
  while (time < release) {
    cpu_relax();
    time = os::now();
  }
  return time;
}

}  // namespace takt::os
