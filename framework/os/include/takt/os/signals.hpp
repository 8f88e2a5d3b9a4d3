// Signals as something to wait for, and the last words of a thread that crashes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// The signals by which a program is asked to end (SIGINT, SIGTERM, SIGHUP), blocked for this thread and
/// those that it starts later, and given out one by one.
class SignalQueue {
 public:
  static Result<SignalQueue> of_requests_to_end();
  /// The next one that has arrived; does not wait.
  std::optional<int> next() const;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
};

/// A write to a pipe whose reader is gone fails from now on, instead of ending this program. Programs that it
/// starts are ended as usual.
void survive_broken_pipes();

/// Waits until one of the descriptors can be read or its other end is gone, at most `limit_ms`; false when
/// none.
bool wait_readable(const std::vector<const Fd*>& fds, int limit_ms);

/// Called in the thread that crashes (SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT), on a stack of its own;
/// afterwards the process ends by the same signal. `at` is the address at which it crashed. To be
/// async-signal-safe; should it crash itself, it is called again for that, once for each signal.
using CrashHandler = void (*)(int signal, std::uintptr_t at) noexcept;
/// Allocates: what walk_stack() needs is loaded here.
void on_crash(CrashHandler handler);

/// A place in a file that is loaded.
struct CodeAt {
  std::uintptr_t address;  ///< as the file counts
  const char* object;      ///< the file; empty: the program itself
};
/// By a CrashHandler: the calls that led to where it crashed, innermost first, one after the other to
/// `found`. A stack that is broken may crash it again.
void walk_stack(std::uintptr_t at, std::size_t most, void (*found)(const CodeAt&) noexcept) noexcept;

/// Gives the calling thread the stack for that, so that a stack overflow is reported too. Kept until the
/// thread ends.
void prepare_crash_stack();

}  // namespace takt::os
