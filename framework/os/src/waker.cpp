#include <takt/os/waker.hpp>

#include <algorithm>

#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>

namespace takt::os {

namespace {
// The margin grows by kUp ns after a wake-up that is later than the margin, and shrinks by kDown ns after any
// other wake-up. kUp is 99 times kDown, so the margin settles where one wake-up in a hundred is later than
// the margin.
constexpr std::int64_t kUp = 990;
constexpr std::int64_t kDown = 10;
constexpr std::int64_t kLeast = 1'000;
}  // namespace

void WakeMargin::observe(Nanoseconds delay) noexcept {
  margin_ns_ += delay.count() > margin_ns_ ? kUp : -kDown;
  margin_ns_ = std::clamp(margin_ns_, std::min(kLeast, cap_ns_), cap_ns_);
}

Nanoseconds margin_cap(Nanoseconds period, double share) noexcept {
  const Nanoseconds most{static_cast<std::int64_t>(static_cast<double>(period.count()) * share)};
  return std::min<Nanoseconds>(most, std::chrono::microseconds{100});
}

Instant Waker::wait_until(Instant release) noexcept {
  constexpr std::uint32_t kAll = ~0U;
  const auto stopped = [this] { return stop_.load(std::memory_order_relaxed) != 0; };
  Instant time = os::now();
  if (strategy_ != model::Wakeup::spin) {
    const Instant wake = release - margin_.value();
    const bool sleeps = time < wake;
    while (time < wake && !stopped()) {  // sleeps a second time only after a spurious wake-up
      futex_wait(stop_, 0, kAll, wake);
      time = os::now();
    }
    if (sleeps && strategy_ == model::Wakeup::hybrid) margin_.observe(time - wake);
  }
  while (time < release && !stopped()) {
    cpu_relax();
    time = os::now();
  }
  return time;
}

}  // namespace takt::os
