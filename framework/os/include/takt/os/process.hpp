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
  int code = 0;  ///< number of the signal, or exit status

  /// Describes the end, for example "ended with status 3" or "was killed by SIGSEGV (Segmentation fault)".
  [[nodiscard]] std::string text() const;
};

/// Describes a signal, for example "SIGSEGV (Segmentation fault)".
std::string signal_text(int signal);

/// SIGTERM and SIGKILL, for code that may not include Linux headers.
extern const int kTerminate;
extern const int kKill;

struct SpawnOptions {
  std::string program{};                 ///< path of the program; PATH is not searched
  std::vector<std::string> arguments{};  ///< arguments, without the program's name
  std::vector<std::pair<std::string, std::string>> environment{};  ///< variables that are added to the
                                                                   ///< environment of this process
  std::vector<const Fd*> inherit{};  ///< descriptors that the program inherits, with the same numbers
  bool capture_output = false;       ///< if true, standard output and error can be read through pipes
  bool new_group = true;             ///< if true, Ctrl-C in the terminal does not reach the program
  bool dies_with_parent = true;  ///< if true, the kernel kills the program when the thread that started it
                                 ///< ends
};

/// A child process. If the child still runs, the destructor kills it and waits for its end.
class Child {
 public:
  Child() = default;
  Child(Child&&) noexcept;
  Child& operator=(Child&&) noexcept;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  /// Starts a program. Fails with the reason if the program cannot be executed; then no process remains. The
  /// other threads of the caller must not hold locks.
  static Result<Child> spawn(const SpawnOptions& options);

  [[nodiscard]] int pid() const noexcept { return pid_; }
  [[nodiscard]] bool running() const noexcept { return pid_ > 0; }
  /// Returns how the child ended; none while it still runs. Returns the end only once, because this call
  /// reaps the child.
  std::optional<ProcessEnd> poll() noexcept;
  /// Waits until the child has ended, and returns how it ended.
  ProcessEnd wait() noexcept;
  /// Sends a signal to the child. Does nothing if the child has ended.
  void signal(int number) const noexcept;

  Fd output;  ///< the child's standard output, non-blocking; only with capture_output
  Fd error;

 private:
  int pid_ = 0;
};

/// Reads the bytes that are available, without waiting; empty if there are none. Sets `end` to true if no
/// more bytes will follow.
std::string read_available(const Fd& fd, bool* end);

/// Runs `work` in a child process and returns its result, so that a crash or a hang of foreign code affects
/// only the child. If this fails, the message begins with `what`. The caller must have only one thread.
Result<std::string> in_child(const std::string& what, const std::function<std::string()>& work,
                             Nanoseconds limit);

/// The folder that contains this program's file.
std::string program_directory();

/// The folder of Takt's internal files (takt-host, libtakt_check.so). In an installation it is the folder
/// that was configured at build time, relative to this program. Otherwise it is the folder of this program.
std::string private_directory();

}  // namespace takt::os
