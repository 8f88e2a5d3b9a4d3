// Makes threads real-time on Linux, and checks whether the system allows it.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// The CPUs on which this process may run, in ascending order.
std::vector<int> allowed_cpus();

/// Returns true if the calling thread has priority over all ordinary threads (SCHED_FIFO, SCHED_RR or
/// SCHED_DEADLINE).
bool is_real_time() noexcept;

/// Gives a thread of any process the policy SCHED_FIFO with a priority from 1 to 99. `tid` 0 means the
/// calling thread.
Result<void> make_real_time(int tid, int priority);
/// Gives a thread of any process the policy SCHED_OTHER with the lowest priority (nice 19). `tid` 0 means the
/// calling thread.
Result<void> make_background(int tid = 0);
/// Restricts a thread to these CPUs; an empty list changes nothing. `tid` 0 means the calling thread.
Result<void> pin(int tid, const std::vector<int>& cpus);

/// Locks all present and future memory of this process in RAM, and makes the heap keep freed pages.
Result<void> lock_memory();

/// Keeps the CPUs out of deep idle states while this object exists, by holding /dev/cpu_dma_latency at 0.
/// held() is false if that device does not exist or cannot be opened.
class NoDeepIdle {
 public:
  NoDeepIdle();
  [[nodiscard]] bool held() const noexcept { return static_cast<bool>(fd_); }

 private:
  Fd fd_;
};

/// Succeeds if a thread of this process may have SCHED_FIFO. Tries it on a new thread.
Result<void> may_have_priority();
/// Succeeds if this process may lock all memory that it will ever have. A limit above its present memory is
/// not enough.
Result<void> may_lock_memory();
/// Checks both of the above. If this fails, the problems state the reasons and what to do.
Result<void> may_be_real_time();

/// The kernel's id of the calling thread.
int thread_id() noexcept;

/// A thread with a stack of fixed size, whose pages are in memory before the thread's body runs.
class Thread {
 public:
  struct Options {
    std::string name;               ///< name of the thread; Linux shows at most 15 bytes of it
    std::optional<int> priority{};  ///< priority for SCHED_FIFO; none: the policy of the thread that creates
                                    ///< it
    std::vector<int> cpus{};        ///< empty: the CPUs of the thread that creates it
    std::size_t stack_bytes = 512 * 1024;
  };

  Thread() = default;
  Thread(Thread&& other) noexcept;
  Thread& operator=(Thread&& other) noexcept;
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;
  /// Waits until the thread has ended.
  ~Thread();

  /// Runs `body` in a new thread. If the system denies the priority or the CPU, the thread runs without it,
  /// and the reason is added to `refused`. Fails only if the thread cannot be created.
  static Result<Thread> start(const Options& options, std::function<void()> body, Problems* refused);

  void join();
  /// Detaches a thread that never ends, so that the destructor does not wait for it.
  void detach();
  [[nodiscard]] bool running() const noexcept { return started_; }

 private:
  unsigned long thread_ = 0;
  bool started_ = false;
};

}  // namespace takt::os
