#include "heartbeat.hpp"

#include <algorithm>

#include <takt/os/clock.hpp>
#include <takt/wire/words.hpp>

namespace takt::node {

void Heartbeat::set(const DeviceStatus& status) {
  {
    const std::lock_guard lock{mutex_};
    status_ = status;
    news_ = true;
  }
  changed_.notify_one();
}

void Heartbeat::wake() {
  {
    const std::lock_guard lock{mutex_};
    news_ = true;
  }
  changed_.notify_one();
}

void Heartbeat::heard(const std::string& node, std::int64_t monotonic_ns, Instant arrived) {
  const std::lock_guard lock{mutex_};
  const auto known = std::find_if(unanswered_.begin(), unanswered_.end(),
                                  [&node](const Heard& one) { return one.node == node; });
  if (known != unanswered_.end())
    *known = {node, monotonic_ns, arrived};
  else if (unanswered_.size() < kMostHeard)
    unanswered_.push_back({node, monotonic_ns, arrived});
}

void Heartbeat::kick(Instant now) {
  const std::lock_guard lock{mutex_};
  kicked_at_ = now;
}

void Heartbeat::serve(DeviceSink& sink) {
  {
    std::unique_lock lock{mutex_};
    changed_.wait_for(lock, kEvery, [this] { return news_; });
  }
  beat(sink, os::now(), os::wall_ns());
}

void Heartbeat::beat(DeviceSink& sink, Instant now, std::int64_t wall_ns) {
  DeviceStatus status;
  {
    const std::lock_guard lock{mutex_};
    news_ = false;
    if (!status_) return;
    status = *status_;
    while (!unanswered_.empty() && status.echoes().size() < kAnswered) {
      const Heard& one = unanswered_.front();
      StatusEcho& echo = status.echoes().emplace_back();
      wire::set(echo.node(), one.node);
      echo.monotonic_ns(one.monotonic_ns);
      echo.held_ns((now - one.arrived).count());
      unanswered_.pop_front();
    }
    if (now - kicked_at_ > kHangs && kicked_at_ != Instant{}) {
      if (status.health() == HEALTH_OK) status.health(HEALTH_DEGRADED);
      const auto silent = std::chrono::duration_cast<std::chrono::seconds>(now - kicked_at_);
      wire::set(status.text(), "the node's main loop has been hanging for " + to_text(Nanoseconds{silent}));
    }
  }
  status.sequence_number(++sequence_);
  status.time_ns(wall_ns);
  status.monotonic_ns(to_ns(now));
  sink.write(status);
  // Publish the status under the new key before the old key is withdrawn, so that no observer sees the device
  // leave in between.
  if (published_ && !(published_->path() == status.path())) sink.dispose(*published_);
  published_ = status;
}

void Heartbeat::leave(DeviceSink& sink) {
  if (published_) sink.dispose(*published_);
  published_.reset();
}

}  // namespace takt::node
