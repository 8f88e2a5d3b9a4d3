// Receives signals through a descriptor, and handles crashes of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// A queue of the signals that ask a program to end (SIGINT, SIGTERM, SIGHUP). These signals are blocked for
/// this thread and for threads that it starts later.
class SignalQueue {
 public:
  static Result<SignalQueue> of_requests_to_end();
  /// Returns the next signal, or none if no signal has arrived. Does not wait.
  std::optional<int> next() const;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
};

/// After this call, a write to a pipe without a reader fails and no longer ends this program. Programs that
/// this program starts keep the default behaviour.
void survive_broken_pipes();

/// Waits up to `limit_ms` until one of the descriptors can be read or its other end has been closed. Returns
/// false if the time runs out first.
bool wait_readable(const std::vector<const Fd*>& fds, int limit_ms);

/// A function that is called when a thread crashes (SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT). It runs in the
/// crashed thread, on a separate stack. After it, the process ends by the same signal. `at` is the address of
/// the crash. The function must be async-signal-safe. If it crashes itself, it is called again, but only once
/// for each signal.
using CrashHandler = void (*)(int signal, std::uintptr_t at) noexcept;
/// Installs the handler. Allocates memory, because it loads the library that walk_stack() needs.
void on_crash(CrashHandler handler);

/// An address in the code of a loaded file.
struct CodeAt {
  std::uintptr_t address;  ///< relative to the start of the file
  const char* object;      ///< path of the file; empty for the program itself
};
/// For a CrashHandler: passes the addresses of the calls that led to the crash to `found`, innermost call
/// first, at most `most` of them. If the stack is corrupt, this may cause another crash.
void walk_stack(std::uintptr_t at, std::size_t most, void (*found)(const CodeAt&) noexcept) noexcept;

/// Gives the calling thread a separate stack for the handler, so that a stack overflow can be handled, too.
/// The separate stack exists until the thread ends.
void prepare_crash_stack();

}  // namespace takt::os
