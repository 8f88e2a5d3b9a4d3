// Starts, watches and ends other programs.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// How a process ended.
struct ProcessEnd {
  bool signalled = false;
  int code = 0;  ///< the signal, or the exit status

  /// "ended with status 3", "was killed by SIGSEGV (Segmentation fault)".
  [[nodiscard]] std::string text() const;
};

/// "SIGSEGV (Segmentation fault)".
std::string signal_text(int signal);

/// SIGTERM and SIGKILL, for rooms that may not include Linux headers.
extern const int kTerminate;
extern const int kKill;

struct SpawnOptions {
  std::string program{};                                           ///< a path; PATH is not searched
  std::vector<std::string> arguments{};                            ///< without the program's own name
  std::vector<std::pair<std::string, std::string>> environment{};  ///< added to that of this process
  std::vector<const Fd*> inherit{};  ///< descriptors that the program gets with the same numbers
  bool capture_output = false;       ///< read standard output and error through pipes
  bool new_group = true;             ///< Ctrl-C in the terminal does not reach the program
  bool dies_with_parent = true;      ///< gets SIGKILL when the thread that started it ends
};

/// A child process. The destructor kills and reaps a child that still runs.
class Child {
 public:
  Child() = default;
  Child(Child&&) noexcept;
  Child& operator=(Child&&) noexcept;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  /// Starts a program. Fails with the reason if the program cannot be executed; then no process is left. The
  /// caller must have no other threads that hold locks.
  static Result<Child> spawn(const SpawnOptions& options);

  [[nodiscard]] int pid() const noexcept { return pid_; }
  [[nodiscard]] bool running() const noexcept { return pid_ > 0; }
  /// Reaps the child if it has ended, and returns how it ended. Returns this only once.
  std::optional<ProcessEnd> poll() noexcept;
  /// Waits for the end.
  ProcessEnd wait() noexcept;
  /// Sends SIGKILL, SIGTERM, ...; does nothing if the child has ended.
  void signal(int number) const noexcept;

  Fd output;  ///< its standard output, non-blocking; only with capture_output
  Fd error;

 private:
  int pid_ = 0;
};

/// Reads the available bytes without waiting; empty if there are none. Sets `end` if no more bytes will
/// follow.
std::string read_available(const Fd& fd, bool* end);

/// Runs `work` in a child process and returns its result, so that a crash or a hang of foreign code affects
/// only the child. If the call fails, its message begins with `what`. The caller must have a single thread.
Result<std::string> in_child(const std::string& what, const std::function<std::string()>& work,
                             Nanoseconds limit);

/// The folder of this program's file.
std::string program_directory();

/// The folder of Takt's internal files (takt-host, libtakt_check.so). In an installation it is the folder for
/// which the build was configured, relative to this program. Otherwise it is the folder of this program.
std::string private_directory();

}  // namespace takt::os
