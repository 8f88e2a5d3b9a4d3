#include "hook_caller.hpp"

#include <utility>

#include <takt/os/clock.hpp>
#include "executor_threads.hpp"

namespace takt::host {

struct HookCaller::Shared {
  Shared(channel::Activity& a, Call c, Done d) : activity(a), call(std::move(c)), done(std::move(d)) {}

  channel::Activity& activity;
  Call call;
  Done done;
  std::mutex mutex;
  std::condition_variable wanted;
  std::deque<Request> queue;
  // The generation of the thread that may serve requests. A thread that was given up has an older generation.
  std::uint64_t generation = 0;
  bool busy = false;
  std::uint32_t module = 0;  // the module whose hook the thread is calling
  bool end = false;

  void serve(std::uint64_t mine) {
    report_crashes_as(&activity);
    std::unique_lock lock{mutex};
    while (true) {
      wanted.wait(lock, [&] { return end || generation != mine || !queue.empty(); });
      if (generation != mine || (end && queue.empty())) return;
      const Request request = queue.front();
      queue.pop_front();
      busy = true;
      module = request.module;
      activity.begin(request.module, request.hook, to_ns(os::now()));
      lock.unlock();
      const Result<std::string> result = call(request);
      lock.lock();
      if (generation != mine) return;
      activity.end();
      busy = false;
      lock.unlock();  // done() may wait for a thread that calls enqueue()
      done(request, result);
      lock.lock();
    }
  }
};

HookCaller::HookCaller(channel::Activity& activity, std::vector<int> cpus, Call call, Done done)
    : cpus_(std::move(cpus)), shared_(std::make_shared<Shared>(activity, std::move(call), std::move(done))) {
  start_thread();
}

HookCaller::~HookCaller() {
  bool stuck = false;
  {
    const std::lock_guard lock{shared_->mutex};
    shared_->end = true;
    shared_->queue.clear();
    stuck = shared_->busy;
  }
  shared_->wanted.notify_all();
  if (stuck) thread_.detach();
}

void HookCaller::start_thread() {
  auto thread = os::Thread::start(
      {.name = "takt-hooks", .cpus = cpus_, .stack_bytes = 8 * 1024 * 1024},
      [shared = shared_, mine = shared_->generation] { shared->serve(mine); }, nullptr);
  TAKT_CHECK(thread.ok());
  thread_ = std::move(*thread);
}

void HookCaller::enqueue(const Request& request) {
  {
    const std::lock_guard lock{shared_->mutex};
    shared_->queue.push_back(request);
  }
  shared_->wanted.notify_all();
}

bool HookCaller::give_up(std::uint32_t module) {
  {
    const std::lock_guard lock{shared_->mutex};
    if (!shared_->busy || shared_->module != module) return false;
    ++shared_->generation;
    shared_->busy = false;
    shared_->activity.end();
  }
  thread_.detach();
  start_thread();
  return true;
}

}  // namespace takt::host
