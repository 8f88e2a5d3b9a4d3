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

bool Outbox::serve(LifecycleLine& line, std::chrono::milliseconds limit) {
  std::unique_lock lock{mutex_};
  wanted_.wait_for(lock, limit, [this] { return woken_ || !entries_.empty(); });
  woken_ = false;
  if (entries_.empty()) return false;
  const Entry entry = std::move(entries_.front());
  entries_.pop_front();
  lock.unlock();
  send(line, entry);
  return true;
}

void Outbox::send(LifecycleLine& line, const Entry& entry) {
  const std::string key = entry.status.path().to_string();
  if (unacknowledged_.contains(key)) {
    in_vain_ = !line.wait_acknowledged(in_vain_ ? kImpatient : kPatient);
    unacknowledged_.clear();  // all of them, or nobody is left to be waited for
  }
  if (entry.disposal) {
    line.dispose(entry.status);
  } else {
    line.write(entry.status);
  }
  unacknowledged_.insert(key);
}

}  // namespace takt::node
