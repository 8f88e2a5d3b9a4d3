#include "fault_rate_limiter.hpp"

namespace takt::node {

using model::FaultKind;

namespace {

bool may_flood(FaultKind kind) {
  switch (kind) {
    case FaultKind::error:
    case FaultKind::recovered:
    case FaultKind::not_recovered:
    case FaultKind::overrun:
    case FaultKind::missed_rows:
    case FaultKind::stale_input:
    case FaultKind::fresh_input:
    case FaultKind::connection_lost:
    case FaultKind::connection_back:
    case FaultKind::device_lost:
    case FaultKind::device_back:
    case FaultKind::refused_command:
    case FaultKind::refused_packet:
    case FaultKind::refused_authentication:
    case FaultKind::not_real_time:
      return true;
    case FaultKind::given_up:
    case FaultKind::host_restart:
    case FaultKind::program_restart:
    case FaultKind::node_start:
    case FaultKind::node_restart:
    case FaultKind::node_end:
    case FaultKind::device_failed:
    case FaultKind::deployed:
    case FaultKind::undeployed:
    case FaultKind::command:
    case FaultKind::failed_command:
      return false;
  }
  return true;
}

}  // namespace

void FaultRateLimiter::put(model::Fault fault, Instant now, const std::string& origin) {
  if (!may_flood(fault.kind)) {
    through_(std::move(fault));
    return;
  }
  Key key{fault.kind, fault.module + "/" + fault.error + "/" + origin};
  if (heaps_.size() >= kMost && !heaps_.contains(key)) key.second.clear();
  const auto [at, added] = heaps_.try_emplace(key);
  Heap& heap = at->second;
  if (added) {
    heap.let_through = now;
    through_(std::move(fault));
    return;
  }
  if (heap.waiting) fault.count += heap.waiting->count;
  heap.waiting = std::move(fault);
}

void FaultRateLimiter::step(Instant now) {
  for (auto at = heaps_.begin(); at != heaps_.end();) {
    Heap& heap = at->second;
    if (now - heap.let_through < kEvery) {
      ++at;
    } else if (heap.waiting) {
      heap.let_through = now;
      through_(std::move(*heap.waiting));
      heap.waiting.reset();
      ++at;
    } else {
      at = heaps_.erase(at);
    }
  }
}

void FaultRateLimiter::flush() {
  for (auto& [key, heap] : heaps_) {
    if (heap.waiting) through_(std::move(*heap.waiting));
    heap.waiting.reset();
  }
}

}  // namespace takt::node
