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

/// Keeps the CPUs out of deep idle states while this object exists, by holding /dev/cpu_dma_latency open with
/// the value 0. held() is false if this device file cannot be opened.
class NoDeepIdle {
 public:
  NoDeepIdle();
  [[nodiscard]] bool held() const noexcept { return static_cast<bool>(fd_); }

 private:
  Fd fd_;
};

/// Succeeds if a thread of this process may have SCHED_FIFO. Starts a thread to try it.
Result<void> may_have_priority();
/// Succeeds if this process may lock all its present and future memory. A memlock limit does not suffice for
/// this, even if it is above the present memory of the process.
Result<void> may_lock_memory();
/// Succeeds if may_have_priority() and may_lock_memory() succeed. Otherwise, the problems state the reasons
/// and what to do.
Result<void> may_be_real_time();

/// Passes the capabilities that real-time programs need on to the programs that this process will start, if
/// it has them (ambient capabilities). The files of these programs then need no capabilities. Call this
/// before the process starts threads, because each thread has its own capabilities.
void pass_on_rights();

/// Returns the kernel's id of the calling thread.
int thread_id() noexcept;

/// A thread with a stack of fixed size, whose pages are in memory before the thread's body runs.
class Thread {
 public:
  struct Options {
    std::string name;  ///< name of the thread; Linux shows at most 15 bytes of it
    /// The priority for SCHED_FIFO. If it is absent, the thread has the policy of its creating thread.
    std::optional<int> priority{};
    /// The CPUs on which the thread may run. If the list is empty, these are the CPUs of its creating thread.
    std::vector<int> cpus{};
    std::size_t stack_bytes = 512 * 1024;
    /// False: the kernel never chooses this thread to handle a signal to the process. A signal that the
    /// thread itself causes, such as SIGSEGV, still reaches it.
    bool handles_signals = true;
  };

  Thread() = default;
  Thread(Thread&& other) noexcept;
  Thread& operator=(Thread&& other) noexcept;
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;
  /// Waits until the thread has ended.
  ~Thread();

  /// Starts a thread that runs `body`. If the system denies the priority or the CPU, the thread runs without
  /// it, and the reason is added to `*refused` (`refused` may be null). Fails only if the thread cannot be
  /// created.
  static Result<Thread> start(const Options& options, std::function<void()> body, Problems* refused);

  void join();
  /// Detaches a thread that may never end, so that the destructor does not wait for it.
  void detach();
  [[nodiscard]] bool running() const noexcept { return started_; }

 private:
  unsigned long thread_ = 0;
  bool started_ = false;
};

}  // namespace takt::os
