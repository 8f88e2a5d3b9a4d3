// Receives signals through a descriptor, and reports crashes of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// A queue of the signals that ask a program to end (SIGINT, SIGTERM, SIGHUP). The signals are blocked for
/// this thread and for threads that it starts later.
class SignalQueue {
 public:
  static Result<SignalQueue> of_requests_to_end();
  /// The next signal that has arrived; does not wait.
  std::optional<int> next() const;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
};

/// From now on, a write to a pipe without a reader fails instead of ending this program. Programs that it
/// starts keep the default behaviour.
void survive_broken_pipes();

/// Waits at most `limit_ms` until one of the descriptors can be read or its other end is gone. Returns false
/// if none of them can.
bool wait_readable(const std::vector<const Fd*>& fds, int limit_ms);

/// Runs in the thread that crashes (SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT), on a separate stack.
/// Afterwards the process ends by the same signal. `at` is the address of the crash. A handler must be
/// async-signal-safe. If it crashes itself, it is called again, once for each signal.
using CrashHandler = void (*)(int signal, std::uintptr_t at) noexcept;
/// Installs the handler. Allocates, because it loads the library that walk_stack() needs.
void on_crash(CrashHandler handler);

/// A place in a loaded file.
struct CodeAt {
  std::uintptr_t address;  ///< relative to the file
  const char* object;      ///< the file; empty: the program itself
};
/// For a CrashHandler: passes the calls that led to the crash to `found`, innermost first, at most `most`. A
/// corrupt stack may cause another crash.
void walk_stack(std::uintptr_t at, std::size_t most, void (*found)(const CodeAt&) noexcept) noexcept;

/// Gives the calling thread a stack for the handler, so that a stack overflow is reported, too. The stack is
/// kept until the thread ends.
void prepare_crash_stack();

}  // namespace takt::os
