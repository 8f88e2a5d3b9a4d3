#include "service_thread.hpp"

#include <atomic>
#include <chrono>
#include <utility>

#include <takt/core/check.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include "executor_threads.hpp"

namespace takt::host {

namespace {
// The longest sleep between two checks for requests. If a host dies after its module wrote a request and
// before it rang the wake word, the request is delayed by at most this time.
constexpr Nanoseconds kLongestSleep = std::chrono::milliseconds{100};
}  // namespace

struct ServiceThread::Shared {
  Shared(const Options& options, std::function<bool()> has_one, std::function<bool()> serves)
      : index(options.index),
        activity(options.activity),
        wake_word(options.wake_word),
        has_request(std::move(has_one)),
        serve_one(std::move(serves)) {}

  std::uint32_t index;
  channel::Activity& activity;
  channel::WakeWord& wake_word;
  std::function<bool()> has_request;
  std::function<bool()> serve_one;
  std::mutex in_module;  // held while a hook or handler of the module is called
  std::atomic<bool> serving{false};
  std::atomic<bool> end{false};

  void serve() {
    report_crashes_as(&activity);
    while (!end.load()) {
      // If another thread rings the wake word after this load, futex_wait() below returns at once. So this
      // thread misses no wake-up.
      const std::uint32_t rings = wake_word.rings.load(std::memory_order_seq_cst);
      if (serve_next()) {
        ring_pending(wake_word);
        continue;
      }
      if (!end.load())
        os::futex_wait(wake_word.rings, rings, channel::kServiceBit, os::now() + kLongestSleep);
    }
  }
  bool serve_next() {
    const std::lock_guard lock{in_module};
    if (end.load() || !has_request()) return false;
    activity.begin(index, channel::Doing::serve, to_ns(os::now()));
    serving.store(true);
    const bool served = serve_one();
    // If `end` is set, the node may have given up this thread during the handler. Then a new thread may
    // already use `activity`.
    if (end.load()) return false;
    serving.store(false);
    activity.end();
    return served;
  }
};

ServiceThread::ServiceThread(const Options& options, std::function<bool()> has_request,
                             std::function<bool()> serve)
    : shared_(std::make_shared<Shared>(options, std::move(has_request), std::move(serve))) {
  auto thread = os::Thread::start(
      {.name = options.name, .cpus = options.cpus, .stack_bytes = 8 * 1024 * 1024},
      [shared = shared_] { shared->serve(); }, nullptr);
  TAKT_CHECK(thread.ok());
  thread_ = std::move(*thread);
}

ServiceThread::~ServiceThread() {
  shared_->end.store(true);
  shared_->wake_word.rings.fetch_add(1, std::memory_order_seq_cst);
  os::futex_wake(shared_->wake_word.rings, channel::kServiceBit);
}

std::unique_lock<std::mutex> ServiceThread::exclude() { return std::unique_lock{shared_->in_module}; }

bool ServiceThread::serves() const noexcept { return shared_->serving.load(); }

void ServiceThread::give_up() {
  shared_->end.store(true);
  if (serves()) shared_->activity.end();
  thread_.detach();
}

}  // namespace takt::host
