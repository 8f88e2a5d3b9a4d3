// Other programs: started, watched, ended.
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

/// SIGTERM and SIGKILL, for who may not name Linux.
extern const int kTerminate;
extern const int kKill;

struct SpawnOptions {
  std::string program{};                                           ///< a path; no search
  std::vector<std::string> arguments{};                            ///< without the program's own name
  std::vector<std::pair<std::string, std::string>> environment{};  ///< added to ours
  std::vector<const Fd*> inherit{};  ///< descriptors that the program gets under the same number
  bool capture_output = false;       ///< standard output and error come back through pipes
  bool new_group = true;             ///< not reached by the terminal's Ctrl-C
  bool dies_with_parent = true;      ///< SIGKILL when the thread that started it ends
};

/// A child process. Destroying it kills and reaps a child that still runs.
class Child {
 public:
  Child() = default;
  Child(Child&&) noexcept;
  Child& operator=(Child&&) noexcept;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  /// Fails when the program cannot be executed, with the reason, and no process is left then. The caller has
  /// no other threads, or none that hold locks.
  static Result<Child> spawn(const SpawnOptions& options);

  [[nodiscard]] int pid() const noexcept { return pid_; }
  [[nodiscard]] bool running() const noexcept { return pid_ > 0; }
  /// Reaps the child if it has ended; says so once.
  std::optional<ProcessEnd> poll() noexcept;
  /// Waits for the end.
  ProcessEnd wait() noexcept;
  /// SIGKILL, SIGTERM, ...; nothing when it has ended.
  void signal(int number) const noexcept;

  Fd output;  ///< reads its standard output, non-blocking; only with capture_output
  Fd error;

 private:
  int pid_ = 0;
};

/// Reads what there is without waiting; empty when there is nothing now. `end` is set when there will be
/// nothing more.
std::string read_available(const Fd& fd, bool* end);

/// Runs `work` in a child process and returns what it returned, so that a crash or a hang of foreign code
/// costs the child and not us. `what` begins the message when it fails. The caller has a single thread.
Result<std::string> in_child(const std::string& what, const std::function<std::string()>& work,
                             Nanoseconds limit);

/// The directory of this program's file.
std::string program_directory();

/// Where Takt keeps what its programs use and people do not start (takt-host, libtakt_check.so): the folder
/// that the build was told for an installation, as it lies from this program, if that is there; else beside
/// this program, as built.
std::string private_directory();

}  // namespace takt::os
