#include <takt/wire/rate_limit.hpp>

#include <algorithm>

namespace takt::wire {

namespace {

constexpr std::size_t kMostClients = 1024;

}  // namespace

void RateLimit::Allowance::fill(Clock::time_point now) {
  const double seconds = std::chrono::duration<double>(now - since).count();
  left = std::min(bound.burst, left + std::max(0.0, seconds) * bound.per_second);
  since = now;
}

bool RateLimit::admit(std::uint64_t client, Clock::time_point now) {
  if (clients_.size() >= kMostClients && !clients_.contains(client)) {
    // Forget the client that has sent nothing for the longest time, because its allowance has had the most
    // time to refill.
    clients_.erase(std::min_element(clients_.begin(), clients_.end(), [](const auto& a, const auto& b) {
      return a.second.since < b.second.since;
    }));
  }
  Allowance& one = clients_.try_emplace(client, Allowance{each_, each_.burst, now}).first->second;
  one.fill(now);
  all_.fill(now);
  if (one.left < 1 || all_.left < 1) return false;
  one.left -= 1;
  all_.left -= 1;
  return true;
}

}  // namespace takt::wire
