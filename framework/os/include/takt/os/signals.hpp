// Receives signals through a file descriptor, and handles crashes of threads.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// A queue of the signals that ask a process to end (SIGINT, SIGTERM, SIGHUP). Creating the queue blocks
/// these signals for the calling thread and for threads that this thread starts later.
class SignalQueue {
 public:
  static Result<SignalQueue> of_requests_to_end();
  /// Returns the next signal; none if no further signal has arrived. Does not wait.
  std::optional<int> next() const;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
};

/// After this call, a write to a pipe without a reader fails, and no longer ends this process. Child
/// processes keep the default behaviour.
void survive_broken_pipes();

/// Blocks the signals of timers and the signals for users (SIGALRM, SIGVTALRM, SIGPROF, SIGIO, SIGUSR1,
/// SIGUSR2 and the real-time signals) for the calling thread and for threads that this thread starts later.
/// So they neither end this process nor interrupt a real-time thread.
void block_user_signals();

/// Waits until one of the file descriptors can be read or its other end has been closed, but at most
/// `limit_ms` ms. Returns false if this limit has passed.
bool wait_readable(const std::vector<const Fd*>& fds, int limit_ms);

/// Waits until standard error takes data, but at most `limit_ms` ms, and then writes as much of `text` as it
/// takes. Returns the number of bytes written; 0 if the limit has passed, because nobody reads the pipe, or
/// the user has stopped the terminal (Ctrl-S). If standard error cannot be written at all, `text` counts as
/// written. If other processes write to the same pipe at this moment, the call may wait longer.
std::size_t write_to_standard_error(std::string_view text, int limit_ms) noexcept;

/// The signal that a supervisor sends to a thread that hangs. The thread calls the CrashHandler, and the
/// process then ends without a core dump. Nothing else sends this signal.
extern const int kHangSignal;

/// A function that is called on a thread that crashes (SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT) or that gets
/// kHangSignal. See prepare_crash_stack() for its stack. When the function returns, the process ends by the
/// same signal. `at` is the address of the code that crashed. The function must be async-signal-safe. If the
/// function itself crashes, it is called again, but only once for each of the signals. If an exception ends
/// the process (see std::terminate()), the function is called with SIGABRT and the text of the exception, and
/// then again with SIGABRT. In all other calls, `exception` is null.
using CrashHandler = void (*)(int signal, std::uintptr_t at, const char* exception) noexcept;
/// Sets the function that is called at a crash. Not for real-time threads: on_crash() allocates memory,
/// because it loads the library that walk_stack() needs.
void on_crash(CrashHandler handler);

/// Makes the function that was passed to on_crash() handle crashes again, if foreign code has replaced the
/// handlers of some signals. Returns the names of these signals, or an empty text.
std::string take_back_crashes();

/// An address in the code of the program or of a shared object.
struct CodeAt {
  std::uintptr_t address;  ///< relative to the load address of `object`
  const char* object;      ///< path of the shared object; empty for the program itself
};
/// Calls `found` with the code address of each call that led to the crash, innermost call first, for at most
/// `most` calls. Only a CrashHandler may use this. If the stack is corrupt, this may cause another crash.
void walk_stack(std::uintptr_t at, std::size_t most, void (*found)(const CodeAt&) noexcept) noexcept;

/// Gives the calling thread a separate stack for the CrashHandler, so that the handler can also run after a
/// stack overflow. The separate stack exists until the thread ends. Unblocks the signals of crashes.
void prepare_crash_stack();

}  // namespace takt::os
