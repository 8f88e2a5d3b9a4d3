#include <takt/wire/notices.hpp>

#include <cstddef>

namespace takt::wire {

namespace {

constexpr std::size_t kMostKnown = 1024;
constexpr int kMostInAMinute = 10;

}  // namespace

void Notices::tell(const std::string& text, Clock::time_point now) {
  std::string more;
  {
    const std::lock_guard lock{mutex_};
    if (now - since_ > std::chrono::minutes{1}) {
      if (held_back_ > 0) more = std::to_string(held_back_) + " more rejections in the last minute";
      since_ = now;
      in_this_minute_ = 0;
      held_back_ = 0;
    }
    if (known_.size() >= kMostKnown) known_.clear();
    if (!known_.insert(text).second) return;
    if (++in_this_minute_ > kMostInAMinute) {
      ++held_back_;
      return;
    }
  }
  if (!told_) return;
  if (!more.empty()) told_(more);
  told_(text);
}

}  // namespace takt::wire
