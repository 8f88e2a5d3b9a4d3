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

/// Whether the calling thread is scheduled before all ordinary threads (SCHED_FIFO, SCHED_RR or
/// SCHED_DEADLINE).
bool is_real_time() noexcept;

/// Gives a thread of any process (0: the caller) SCHED_FIFO with a priority of 1 to 99.
Result<void> make_real_time(int tid, int priority);
/// Gives a thread of any process (0: the caller) SCHED_OTHER at the lowest priority (nice 19).
Result<void> make_background(int tid = 0);
/// Restricts a thread (0: the caller) to these CPUs; an empty list changes nothing.
Result<void> pin(int tid, const std::vector<int>& cpus);

/// Keeps all memory of this process, present and future, in RAM, and keeps the heap from giving pages back.
Result<void> lock_memory();

/// Keeps the CPUs out of deep idle states while this object exists (/dev/cpu_dma_latency at 0). held() is
/// false if the device does not exist or cannot be opened.
class NoDeepIdle {
 public:
  NoDeepIdle();
  [[nodiscard]] bool held() const noexcept { return static_cast<bool>(fd_); }

 private:
  Fd fd_;
};

/// Whether a thread of this process may have SCHED_FIFO. Tries it on a new thread.
Result<void> may_have_priority();
/// Whether this process may lock all memory that it will ever have. A limit above its present memory does not
/// suffice.
Result<void> may_lock_memory();
/// Checks both of the above. Fails with the reasons and what to do.
Result<void> may_be_real_time();

/// The calling thread's id.
int thread_id() noexcept;

/// A thread with a stack of fixed size, whose pages are in memory before the body runs.
class Thread {
 public:
  struct Options {
    std::string name;               ///< at most 15 bytes are shown
    std::optional<int> priority{};  ///< SCHED_FIFO; none: that of the creator
    std::vector<int> cpus{};        ///< empty: those of the creator
    std::size_t stack_bytes = 512 * 1024;
  };

  Thread() = default;
  Thread(Thread&& other) noexcept;
  Thread& operator=(Thread&& other) noexcept;
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;
  /// Waits for the end of the thread.
  ~Thread();

  /// Runs `body` in a new thread. If the system denies the priority or the CPU, the thread runs without it
  /// and the reason is added to `refused`. Fails only if the thread cannot be created.
  static Result<Thread> start(const Options& options, std::function<void()> body, Problems* refused);

  void join();
  /// Detaches a thread that will never end.
  void detach();
  [[nodiscard]] bool running() const noexcept { return started_; }

 private:
  unsigned long thread_ = 0;
  bool started_ = false;
};

}  // namespace takt::os
