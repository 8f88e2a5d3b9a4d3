#include <takt/node/worker.hpp>

#include <utility>

namespace takt::node {

Result<std::unique_ptr<Worker>> Worker::start(const std::string& name) {
  std::unique_ptr<Worker> worker{new Worker};
  auto thread = os::Thread::start(
      {.name = name}, [place = worker.get()] { place->run(); }, nullptr);
  if (!thread) return thread.problems();
  worker->thread_ = std::move(*thread);
  return worker;
}

Worker::~Worker() {
  {
    const std::lock_guard lock{mutex_};
    ending_ = true;
  }
  changed_.notify_all();
  thread_.join();
}

void Worker::add(std::function<void()> work) {
  {
    const std::lock_guard lock{mutex_};
    waiting_.push_back(std::move(work));
  }
  changed_.notify_all();
}

bool Worker::is_idle() {
  const std::lock_guard lock{mutex_};
  return !calling_ && waiting_.empty();
}

void Worker::run() {
  std::unique_lock lock{mutex_};
  while (true) {
    changed_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    if (ending_) return;
    const std::function<void()> work = std::move(waiting_.front());
    waiting_.pop_front();
    calling_ = true;
    lock.unlock();
    work();
    lock.lock();
    calling_ = false;
  }
}

}  // namespace takt::node
