// Starts, watches and ends child processes.
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
  int code = 0;  ///< number of the signal if `signalled`, otherwise the exit status
  // With SpawnOptions::whole_tree:
  bool left_others = false;    ///< processes that it had started still ran
  bool keeper_killed = false;  ///< it was ended because its takt-keeper was killed

  /// Describes the end, for example "ended with status 3" or "was killed by SIGSEGV (Segmentation fault)".
  [[nodiscard]] std::string text() const;
};

/// Describes a signal, for example "SIGSEGV (Segmentation fault)".
std::string signal_text(int signal);

/// The numbers of SIGTERM and SIGKILL, for code that may not include Linux headers.
extern const int kTerminate;
extern const int kKill;

struct SpawnOptions {
  std::string program{};  ///< path of the program; PATH is not searched
  /// A file to execute instead of the file `program`; null: none. The new program still gets `program` as its
  /// name (argv[0]). If the file is a script, its interpreter inherits this descriptor and reads the script
  /// from it.
  const Fd* copy = nullptr;
  std::vector<std::string> arguments{};  ///< arguments, without the program's name
  /// Variables that the program gets in addition to those of this process.
  std::vector<std::pair<std::string, std::string>> environment{};
  /// The only file descriptors, besides standard input, output and error, that the program inherits. They
  /// keep their numbers.
  std::vector<const Fd*> inherit{};
  /// The CPUs on which the program may run; an empty list means the CPUs of the calling thread. If the system
  /// denies them, the program runs on the CPUs of the calling thread.
  std::vector<int> cpus{};
  /// True: the parent reads the program's output from Child::output and Child::error.
  bool capture_output = false;
  bool new_group = true;  ///< true: Ctrl-C in the terminal does not reach the program
  /// True: the kernel kills the program when the thread that started it ends.
  bool dies_with_parent = true;
  /// True: takt-keeper starts the program. When the program or the thread that started it ends, takt-keeper
  /// ends all processes that the program has started, wherever they are: in other sessions, or without a
  /// parent. The program's end is reported after the end of these processes. They get SIGTERM and then, half
  /// a second later, SIGKILL; if SIGKILL ended the program or the thread has ended, they get SIGKILL at once.
  bool whole_tree = false;
  /// True: the program's end is reported at once, and takt-keeper ends the other processes only when the
  /// Child is destroyed. Only with whole_tree.
  bool others_stay = false;
};

/// A child process. If it still runs, the destructor kills it and waits for its end.
///
/// poll() reports the end of a child before it reaps the child, because reaping can take seconds: the kernel
/// waits in a busy loop if the last thread of the child has not quite ended and has no CPU. A later call of
/// poll() or the destructor reaps the child, even if another child was assigned to this object in the
/// meantime.
class Child {
 public:
  Child() = default;
  Child(Child&&) noexcept;
  Child& operator=(Child&&) noexcept;
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child();

  /// Starts a program as a child process. Fails with the reason if the program cannot be executed; then no
  /// process remains. Other threads of this process may run during the call.
  static Result<Child> spawn(const SpawnOptions& options);

  [[nodiscard]] int pid() const noexcept { return pid_; }
  [[nodiscard]] bool running() const noexcept { return pid_ > 0; }
  /// Returns how the child ended; none while it still runs. Returns the end only once, and none after that.
  std::optional<ProcessEnd> poll() noexcept;
  /// Waits until the child has ended, and returns how it ended.
  ProcessEnd wait() noexcept;
  /// Sends a signal to the child; with whole_tree, to its process group. Does nothing if the child has ended.
  void signal(int number) const noexcept;
  /// Sends a signal to one thread of the child. Does nothing if the child or the thread has ended.
  void signal_thread(int thread, int number) const noexcept;

  Fd output;  ///< the child's standard output, which is read without waiting; only with capture_output
  Fd error;

 private:
  std::optional<ProcessEnd> kept_end() noexcept;
  void end_keeper() noexcept;
  void reap() noexcept;

  int pid_ = 0;
  int keeper_ = 0;  // PID of takt-keeper; 0 without whole_tree
  bool others_stay_ = false;
  Fd kept_;         // the pipe on which takt-keeper reports the start and the end of the program
  int zombie_ = 0;  // PID of a child that has ended but is not reaped yet, or of its takt-keeper
  Instant reap_at_{};
};

/// Returns the bytes that have arrived, without waiting; empty if there are none. Sets `end` to true if no
/// more bytes will follow.
std::string read_available(const Fd& fd, bool* end);

/// Runs `work` in a child process and returns the result of `work`. So a crash or a hang of foreign code
/// affects only the child. Fails if the child crashes or does not end within `limit`; the message begins with
/// `what`. The calling process must have only one thread.
Result<std::string> in_child(const std::string& what, const std::function<std::string()>& work,
                             Nanoseconds limit);

/// Returns the folder that contains the file of the running program.
std::string program_directory();

/// Returns the folder of Takt's internal files (takt-host, takt-keeper, libtakt_check.so). In an
/// installation, the path from program_directory() to this folder was set at build time. Otherwise this
/// folder is program_directory().
std::string private_directory();

}  // namespace takt::os
