#include <takt/os/real_time.hpp>

#include <fcntl.h>
#include <linux/capability.h>
#include <malloc.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <utility>

#include <takt/os/environment.hpp>
#include "error.hpp"

namespace takt::os {

namespace {

// The capabilities that a real-time program needs.
constexpr std::array<int, 2> kCapabilities{CAP_SYS_NICE, CAP_IPC_LOCK};

class Capabilities {
 public:
  /// Reads the capabilities of the calling thread.
  Capabilities() { ::syscall(SYS_capget, &header_, data_.data()); }

  [[nodiscard]] bool effective(int capability) const { return has(data_[0].effective, capability); }
  [[nodiscard]] bool permitted(int capability) const { return has(data_[0].permitted, capability); }
  void make_inheritable(int capability) {
    data_[0].inheritable |= 1U << static_cast<unsigned>(capability);
    ::syscall(SYS_capset, &header_, data_.data());
  }

 private:
  static bool has(std::uint32_t set, int capability) {
    return (set & (1U << static_cast<unsigned>(capability))) != 0;
  }

  __user_cap_header_struct header_{.version = _LINUX_CAPABILITY_VERSION_3, .pid = 0};
  std::array<__user_cap_data_struct, _LINUX_CAPABILITY_U32S_3> data_{};
};

std::string fifo_cure() {
  if (Capabilities{}.effective(CAP_SYS_NICE))
    return "use a priority from 1 to 99, and give the cgroup of this process real-time CPU time "
           "(cpu.rt_runtime_us)";
  return is_root()
             ? "root lacks CAP_SYS_NICE here: add it to the container (--cap-add SYS_NICE), or raise the "
               "rtprio limit (--ulimit rtprio=99)"
             : "run as root, or give takt-node CAP_SYS_NICE or an rtprio limit (ulimit -r)";
}

std::string lock_cure() {
  return is_root()
             ? "root lacks CAP_IPC_LOCK here: add it to the container (--cap-add IPC_LOCK), or raise the "
               "memlock limit (--ulimit memlock=-1)"
             : "run as root, or give takt-node CAP_IPC_LOCK or raise the memlock limit (ulimit -l "
               "unlimited)";
}

// Returns the number of free bytes on the calling thread's stack. The C library puts the thread-local
// variables of all libraries on the stack, and these variables may take most of the requested size.
std::size_t stack_left() {
  pthread_attr_t attributes;
  if (::pthread_getattr_np(::pthread_self(), &attributes) != 0) return 0;
  void* lowest = nullptr;
  std::size_t size = 0;
  ::pthread_attr_getstack(&attributes, &lowest, &size);
  ::pthread_attr_destroy(&attributes);
  return reinterpret_cast<std::uintptr_t>(__builtin_frame_address(0)) -
         reinterpret_cast<std::uintptr_t>(lowest);
}

// Maps pages of the thread's stack in advance, by writing to them. Uses only half of the free part, because
// the functions that are running use the stack, too.
[[gnu::noinline]] void touch_stack(std::size_t requested) {
  const std::size_t bytes = std::min(requested, stack_left()) / 2;
  auto* stack = static_cast<volatile char*>(__builtin_alloca(bytes));
  for (std::size_t i = 0; i < bytes; i += 4096) stack[i] = 0;
}

struct Start {
  Thread::Options options;
  std::function<void()> body;
};

void* run_thread(void* argument) {
  const std::unique_ptr<Start> start{static_cast<Start*>(argument)};
  ::prctl(PR_SET_NAME, start->options.name.substr(0, 15).c_str());
  ::prctl(PR_SET_TIMERSLACK, 1UL);
  touch_stack(start->options.stack_bytes);
  start->body();
  return nullptr;
}

}  // namespace

bool is_real_time() noexcept {
  const int policy = ::sched_getscheduler(0) & ~SCHED_RESET_ON_FORK;
  return policy != SCHED_OTHER && policy != SCHED_BATCH && policy != SCHED_IDLE;
}

Result<void> make_real_time(int tid, int priority) {
  const sched_param parameter{.sched_priority = priority};
  if (::sched_setscheduler(tid, SCHED_FIFO | SCHED_RESET_ON_FORK, &parameter) != 0) {
    return errno_problem("SCHED_FIFO " + std::to_string(priority) + " is denied", fifo_cure());
  }
  return {};
}

Result<void> make_background(int tid) {
  constexpr int kLowest = 19;
  const sched_param parameter{.sched_priority = 0};
  if (::sched_setscheduler(tid, SCHED_OTHER, &parameter) != 0) return errno_problem("SCHED_OTHER is denied");
  if (::setpriority(PRIO_PROCESS, static_cast<id_t>(tid), kLowest) != 0)
    return errno_problem("nice 19 is denied");
  return {};
}

Result<void> pin(int tid, const std::vector<int>& cpus) {
  if (cpus.empty()) return {};
  cpu_set_t set;
  CPU_ZERO(&set);
  std::string names;
  for (int cpu : cpus) {
    CPU_SET(static_cast<unsigned>(cpu), &set);
    names += (names.empty() ? "" : ",") + std::to_string(cpu);
  }
  if (::sched_setaffinity(tid, sizeof set, &set) != 0) {
    return errno_problem("CPU " + names + " is denied", "use a CPU that this machine has");
  }
  return {};
}

Result<void> lock_memory() {
  if (auto all = may_lock_memory(); !all) return all;
  // From now on, the heap keeps freed memory and serves large blocks itself, so that new blocks are in locked
  // memory.
  ::mallopt(M_TRIM_THRESHOLD, -1);
  ::mallopt(M_MMAP_MAX, 0);
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0)
    return errno_problem("mlockall is denied", "free memory, or raise the memory limit of the cgroup");
  return {};
}

NoDeepIdle::NoDeepIdle() : fd_(::open("/dev/cpu_dma_latency", O_WRONLY | O_CLOEXEC)) {
  const std::int32_t microseconds = 0;
  if (fd_ && ::write(fd_.get(), &microseconds, sizeof microseconds) != sizeof microseconds) fd_.close();
}

Result<void> may_have_priority() {
  Problems problems;
  auto attempt = Thread::start(
      {.name = "takt-probe", .priority = 1}, [] {}, &problems);
  if (!attempt) return attempt.problems();
  attempt->join();
  if (!problems.empty()) return problems;
  return {};
}

// Fails if the memlock limit is finite and the process does not have CAP_IPC_LOCK, even if the limit is above
// the present memory. mlockall() also locks future memory, so the first thread or allocation beyond the limit
// would fail.
Result<void> may_lock_memory() {
  rlimit limit{};
  ::getrlimit(RLIMIT_MEMLOCK, &limit);
  if (limit.rlim_cur == RLIM_INFINITY) return {};
  if (Capabilities{}.effective(CAP_IPC_LOCK)) return {};
  return fail("mlockall is denied beyond " + std::to_string(limit.rlim_cur / 1024) + " KiB", lock_cure());
}

Result<void> may_be_real_time() {
  Problems problems;
  for (const Result<void>& allowed : {may_have_priority(), may_lock_memory()}) {
    if (!allowed) problems.insert(problems.end(), allowed.problems().begin(), allowed.problems().end());
  }
  if (!problems.empty()) return problems;
  return {};
}

void pass_on_rights() {
  Capabilities mine;
  for (const int capability : kCapabilities) {
    if (!mine.permitted(capability)) continue;
    mine.make_inheritable(capability);
    ::prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_RAISE, capability, 0, 0);
  }
}

int thread_id() noexcept { return static_cast<int>(::syscall(SYS_gettid)); }

Thread::Thread(Thread&& other) noexcept
    : thread_(other.thread_), started_(std::exchange(other.started_, false)) {}

Thread& Thread::operator=(Thread&& other) noexcept {
  if (this != &other) {
    join();
    thread_ = other.thread_;
    started_ = std::exchange(other.started_, false);
  }
  return *this;
}

Thread::~Thread() { join(); }

Result<Thread> Thread::start(const Options& options, std::function<void()> body, Problems* refused) {
  pthread_attr_t attributes;
  ::pthread_attr_init(&attributes);
  ::pthread_attr_setstacksize(&attributes, options.stack_bytes);
  sigset_t before;
  if (!options.handles_signals) {
    sigset_t blocked;
    ::sigfillset(&blocked);
    for (const int own : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT, SIGSYS})
      ::sigdelset(&blocked, own);
    // The new thread inherits this. With pthread_attr_setsigmask_np(), AddressSanitizer would undo it there.
    ::pthread_sigmask(SIG_SETMASK, &blocked, &before);
  }
  // The new thread itself sets its priority and CPU before it runs `body`. If the system denies them, the
  // thread runs without them.
  auto ready = std::make_shared<std::atomic<bool>>(false);
  auto prepared = [ready, options, body = std::move(body), refused] {
    Problems mine;
    const auto add = [&mine](const Result<void>& result) {
      if (!result) mine.insert(mine.end(), result.problems().begin(), result.problems().end());
    };
    add(pin(0, options.cpus));
    if (options.priority) add(make_real_time(0, *options.priority));
    for (Problem& problem : mine) {
      problem.where = "thread " + options.name;
      if (refused != nullptr) refused->push_back(problem);
    }
    ready->store(true, std::memory_order_release);
    ready->notify_one();
    body();
  };
  auto start = std::make_unique<Start>(Start{options, std::move(prepared)});

  Thread thread;
  const int error = ::pthread_create(&thread.thread_, &attributes, run_thread, start.get());
  ::pthread_attr_destroy(&attributes);
  if (!options.handles_signals) ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (error != 0)
    return error_problem("a thread could not be created", error, "free memory or raise the limit on threads");
  start.release();  // NOLINT(bugprone-unused-return-value): the new thread owns it
  thread.started_ = true;
  ready->wait(false, std::memory_order_acquire);
  return thread;
}

void Thread::join() {
  if (std::exchange(started_, false)) ::pthread_join(thread_, nullptr);
}

void Thread::detach() {
  if (std::exchange(started_, false)) ::pthread_detach(thread_);
}

}  // namespace takt::os
