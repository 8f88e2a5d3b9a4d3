#include <takt/lifecycle/recovery.hpp>

#include <algorithm>

namespace takt::lifecycle {

void Recovery::failed(Instant now, std::optional<Instant> since) noexcept {
  const Nanoseconds lasting = std::max<Nanoseconds>(std::chrono::seconds{1}, 10 * policy_.backoff);
  if (running_ && since.value_or(now) - recovered_at_ >= lasting) made_ = 0;
  running_ = false;
  not_before_ = now + policy_.backoff;
}

void Recovery::attempted(Instant now, bool recovered) noexcept {
  running_ = recovered;
  if (recovered) {
    recovered_at_ = now;
  } else {
    not_before_ = now + policy_.backoff;
  }
}

Recovery::Step Recovery::next(Instant now, bool counts) noexcept {
  if (made_ >= policy_.attempts && (counts || policy_.attempts == 0)) return Step::give_up;
  if (now < not_before_) return Step::wait;
  if (counts) ++made_;
  return Step::attempt;
}

}  // namespace takt::lifecycle
