#include <map>
#include <mutex>
#include <utility>
#include <vector>

#include <takt/host/host.hpp>
#include "own_threads.hpp"

namespace takt::host {

namespace {

struct ModuleTimer {
  std::function<void()> expire;
  std::function<void()> remove = [] {};
  const void* handle = nullptr;
  std::uint32_t owner = 0;             // index of the module, plus 1
  std::weak_ptr<const char> instance;  // see own_threads.hpp
  bool stopped = false;
};

/// The timers of all modules, by their ids. An id is never used again, so a late expiry finds no other timer.
class ModuleTimers {
 public:
  std::uint64_t add(ModuleTimer timer) {
    const std::lock_guard lock{mutex_};
    timers_.emplace(++last_, std::move(timer));
    return last_;
  }
  void created(std::uint64_t id, const void* handle, std::function<void()> remove) {
    const std::lock_guard lock{mutex_};
    timers_[id].handle = handle;
    timers_[id].remove = std::move(remove);
  }
  void erase(std::uint64_t id) {
    const std::lock_guard lock{mutex_};
    timers_.erase(id);
  }
  void erase(const void* handle) {
    const std::lock_guard lock{mutex_};
    std::erase_if(timers_, [handle](const auto& timer) { return timer.second.handle == handle; });
  }
  void stop(const OwnThreads& instance) {
    const std::lock_guard lock{mutex_};
    for (auto& [id, timer] : timers_) timer.stopped |= timer.instance.lock() == instance;
  }
  bool remove(const OwnThreads& instance) {
    std::vector<ModuleTimer> left;
    {
      const std::lock_guard lock{mutex_};
      std::erase_if(timers_, [&](auto& timer) {
        if (timer.second.instance.lock() != instance) return false;
        left.push_back(std::move(timer.second));
        return true;
      });
    }
    for (const ModuleTimer& timer : left) timer.remove();
    return !left.empty();
  }
  /// Returns what the timer does when it expires, with the reference that keeps the module's code in memory
  /// meanwhile; nothing if the timer was deleted or stopped.
  std::pair<ModuleTimer, OwnThreads> find(std::uint64_t id) {
    const std::lock_guard lock{mutex_};
    const auto at = timers_.find(id);
    if (at == timers_.end() || at->second.stopped) return {};
    return {at->second, at->second.instance.lock()};
  }

 private:
  std::mutex mutex_;
  std::map<std::uint64_t, ModuleTimer> timers_;
  std::uint64_t last_ = 0;
};

ModuleTimers& timers() {
  static auto* const all =
      new ModuleTimers;  // never destroyed, because a timer may expire until the process ends
  return *all;
}

}  // namespace

std::uint64_t add_timer_of_module(std::function<void()> expire) {
  const auto thread = thread_of_module(nullptr, nullptr);
  if (!thread || thread->instance == nullptr) return 0;
  return timers().add({.expire = std::move(expire), .owner = thread->owner, .instance = thread->instance});
}

void timer_of_module_created(std::uint64_t id, const void* handle, std::function<void()> remove) {
  timers().created(id, handle, std::move(remove));
}

void timer_of_module_failed(std::uint64_t id) { timers().erase(id); }

void timer_deleted(const void* handle) { timers().erase(handle); }

void run_timer_of_module(std::uint64_t id) {
  auto [timer, instance] = timers().find(id);
  if (instance == nullptr) return;
  const auto expire = [](void* function) -> void* {
    (*static_cast<std::function<void()>*>(function))();
    return nullptr;
  };
  run_thread_of_module(new ModuleThread{
      .body = expire, .argument = &timer.expire, .owner = timer.owner, .instance = std::move(instance)});
}

void stop_timers(const OwnThreads& instance) { timers().stop(instance); }

bool delete_timers(const OwnThreads& instance) { return timers().remove(instance); }

}  // namespace takt::host
