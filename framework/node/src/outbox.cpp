#include "outbox.hpp"

namespace takt::node {

void Outbox::put(const LifecycleStatus& status) {
  {
    const std::lock_guard lock{mutex_};
    entries_.push_back({status, false});
  }
  wanted_.notify_one();
}

void Outbox::put_disposal(const LifecycleStatus& key) {
  {
    const std::lock_guard lock{mutex_};
    entries_.push_back({key, true});
  }
  wanted_.notify_one();
}

void Outbox::wake() {
  {
    const std::lock_guard lock{mutex_};
    woken_ = true;
  }
  wanted_.notify_one();
}

bool Outbox::serve(LifecycleSink& sink, std::chrono::milliseconds limit) {
  std::unique_lock lock{mutex_};
  wanted_.wait_for(lock, limit, [this] { return woken_ || !entries_.empty(); });
  woken_ = false;
  if (entries_.empty()) return false;
  const Entry entry = std::move(entries_.front());
  entries_.pop_front();
  lock.unlock();
  send(sink, entry);
  return true;
}

void Outbox::send(LifecycleSink& sink, const Entry& entry) {
  const std::string key = entry.status.path().to_string();
  if (unacknowledged_.contains(key)) {
    last_wait_failed_ = !sink.wait_acknowledged(last_wait_failed_ ? kImpatient : kPatient);
    unacknowledged_.clear();  // all samples were acknowledged, or the wait has failed
  }
  if (entry.disposal) {
    sink.dispose(entry.status);
  } else {
    sink.write(entry.status);
  }
  unacknowledged_.insert(key);
}

}  // namespace takt::node
