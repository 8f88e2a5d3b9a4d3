#include "rate_limit.hpp"

#include <algorithm>

namespace takt::dds {

namespace {

constexpr std::size_t kMostAskers = 1024;

}  // namespace

void RateLimit::Allowance::fill(Clock::time_point now) {
  const double seconds = std::chrono::duration<double>(now - since).count();
  left = std::min(bound.at_once, left + std::max(0.0, seconds) * bound.a_second);
  since = now;
}

bool RateLimit::admit(std::uint64_t asker, Clock::time_point now) {
  if (askers_.size() >= kMostAskers && !askers_.contains(asker)) {
    // Whoever was quiet for longest has most of its allowance again.
    askers_.erase(std::min_element(askers_.begin(), askers_.end(), [](const auto& a, const auto& b) {
      return a.second.since < b.second.since;
    }));
  }
  Allowance& one = askers_.try_emplace(asker, Allowance{each_, each_.at_once, now}).first->second;
  one.fill(now);
  all_.fill(now);
  if (one.left < 1 || all_.left < 1) return false;
  one.left -= 1;
  all_.left -= 1;
  return true;
}

}  // namespace takt::dds
