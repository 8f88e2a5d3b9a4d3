#include "heartbeat.hpp"

#include <takt/dds/words.hpp>
#include <takt/os/clock.hpp>

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

void Heartbeat::sign(Instant now) {
  const std::lock_guard lock{mutex_};
  signed_at_ = now;
}

void Heartbeat::serve(DeviceLine& line) {
  {
    std::unique_lock lock{mutex_};
    changed_.wait_for(lock, kEvery, [this] { return news_; });
  }
  beat(line, os::now(), os::wall_ns());
}

void Heartbeat::beat(DeviceLine& line, Instant now, std::int64_t wall_ns) {
  DeviceStatus status;
  {
    const std::lock_guard lock{mutex_};
    news_ = false;
    if (!status_) return;
    status = *status_;
    if (now - signed_at_ > kHangs && signed_at_ != Instant{}) {
      if (status.health() == HEALTH_OK) status.health(HEALTH_DEGRADED);
      const auto silent = std::chrono::duration_cast<std::chrono::seconds>(now - signed_at_);
      dds::set(status.text(), "the node itself has been hanging for " + to_text(Nanoseconds{silent}));
    }
  }
  status.sequence_number(++sequence_);
  status.time_ns(wall_ns);
  line.write(status);
  // The new key is said before the old one is taken back, so that nobody sees the device leave in between.
  if (said_ && !(said_->path() == status.path())) line.dispose(*said_);
  said_ = status;
}

void Heartbeat::leave(DeviceLine& line) {
  if (said_) line.dispose(*said_);
  said_.reset();
}

}  // namespace takt::node
