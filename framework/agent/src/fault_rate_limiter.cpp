#include <takt/agent/fault_rate_limiter.hpp>

namespace takt::agent {

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
    case FaultKind::clocks_differ:
    case FaultKind::clocks_agree:
    case FaultKind::refused_command:
    case FaultKind::refused_packet:
    case FaultKind::refused_authentication:
    case FaultKind::not_real_time:
    case FaultKind::dropped_samples:
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
    case FaultKind::log_error:  // the supervisor limits the rate of each module's log lines
    case FaultKind::log_warning:
    case FaultKind::log_info:
    case FaultKind::log_debug:
    case FaultKind::forced:
    case FaultKind::force_ended:
    case FaultKind::acknowledged:
      return false;
  }
  return true;
}

}  // namespace

void FaultRateLimiter::put(model::Fault fault, Instant now, const std::string& origin) {
  if (!may_flood(fault.kind)) {
    emit_(std::move(fault));
    return;
  }
  Key key{fault.kind, fault.module + "/" + fault.error + "/" + origin};
  if (buckets_.size() >= kMost && !buckets_.contains(key)) key.second.clear();
  const auto [at, added] = buckets_.try_emplace(key);
  Bucket& bucket = at->second;
  if (added) {
    bucket.passed_at = now;
    emit_(std::move(fault));
    return;
  }
  if (bucket.merged) fault.count += bucket.merged->count;
  bucket.merged = std::move(fault);
}

void FaultRateLimiter::step(Instant now) {
  for (auto at = buckets_.begin(); at != buckets_.end();) {
    Bucket& bucket = at->second;
    if (now - bucket.passed_at < kEvery) {
      ++at;
    } else if (bucket.merged) {
      bucket.passed_at = now;
      emit_(std::move(*bucket.merged));
      bucket.merged.reset();
      ++at;
    } else {
      at = buckets_.erase(at);
    }
  }
}

void FaultRateLimiter::flush() {
  for (auto& [key, bucket] : buckets_) {
    if (bucket.merged) emit_(std::move(*bucket.merged));
    bucket.merged.reset();
  }
}

}  // namespace takt::agent
