#include "heartbeat.hpp"

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
    if (now - kicked_at_ > kHangs && kicked_at_ != Instant{}) {
      if (status.health() == HEALTH_OK) status.health(HEALTH_DEGRADED);
      const auto silent = std::chrono::duration_cast<std::chrono::seconds>(now - kicked_at_);
      wire::set(status.text(), "the node's main loop has been hanging for " + to_text(Nanoseconds{silent}));
    }
  }
  status.sequence_number(++sequence_);
  status.time_ns(wall_ns);
  sink.write(status);
  // The new key is published before the old key is withdrawn, so that no observer sees the device leave in
  // between.
  if (published_ && !(published_->path() == status.path())) sink.dispose(*published_);
  published_ = status;
}

void Heartbeat::leave(DeviceSink& sink) {
  if (published_) sink.dispose(*published_);
  published_.reset();
}

}  // namespace takt::node
