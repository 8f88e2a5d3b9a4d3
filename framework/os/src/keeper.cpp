#include <takt/os/keeper.hpp>

#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <string>
#include <vector>

#include <takt/os/clock.hpp>
#include "script.hpp"

namespace takt::os {

namespace {

/// The time that processes may take to end on SIGTERM after their program has ended.
constexpr Nanoseconds kEndWithin = std::chrono::milliseconds{500};
/// The interval at which the keeper looks for processes that SIGKILL must still end.
constexpr Nanoseconds kKillEvery = std::chrono::milliseconds{100};

/// Returns the children of this process, of which only the main thread may have any. These are also processes
/// whose parent has ended, because the kernel makes the keeper their parent.
std::vector<int> children() {
  std::vector<int> found;
  const std::string path = "/proc/self/task/" + std::to_string(::getpid()) + "/children";
  if (std::FILE* const file = std::fopen(path.c_str(), "re")) {
    for (int pid = 0; std::fscanf(file, "%d", &pid) == 1;) found.push_back(pid);
    std::fclose(file);
  }
  return found;
}

/// The keeper of a program, which remains a zombie when it has ended.
class Keeper {
 public:
  Keeper(int pid, const sigset_t& awaited) : pid_(pid), awaited_(awaited) {}

  /// Waits until the program or the node has ended.
  void wait_for_end() {
    while (!node_ended_ && !has_ended()) {
      visit_others(0);
      wait(std::chrono::hours{1});
    }
    visit_others(0);  // reaps those that have ended
    left_others_ = visit_others(0);
  }

  /// Ends all processes of the program.
  void end_all() {
    const bool killed = has_ended() && end_.si_code != CLD_EXITED && end_.si_status == SIGKILL;
    const Instant kill_at = now() + (killed ? Nanoseconds{0} : kEndWithin);
    while (true) {
      const bool kills = node_ended_ || now() >= kill_at;
      const int number = kills ? SIGKILL : SIGTERM;
      ::kill(-pid_, number);
      const bool ended = has_ended();  // first, because its end leaves its children to this process
      if (!visit_others(number) && ended) break;
      wait(kills ? kKillEvery : std::max(kill_at - now(), Nanoseconds{0}));
    }
  }

  void wait_for_end_of_node() {
    while (!node_ended_) wait(std::chrono::hours{1});
  }
  [[nodiscard]] bool node_ended() const { return node_ended_; }

  [[nodiscard]] KeptEnd end() const {
    return {.signalled = end_.si_code != CLD_EXITED, .code = end_.si_status, .left_others = left_others_};
  }

  /// Waits for the end of the program, which is a keeper itself, and passes SIGTERM on to it. Then kills the
  /// processes that it has left because it was killed.
  void guard() {
    while (!has_ended()) {
      wait(std::chrono::hours{1});
      if (node_ended_) ::kill(pid_, SIGTERM);
    }
    while (visit_others(SIGKILL)) wait(kKillEvery);
  }

 private:
  bool has_ended() {
    end_.si_pid = 0;
    return ::waitid(P_PID, static_cast<id_t>(pid_), &end_, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           end_.si_pid == pid_;
  }

  /// Reaps the other processes that have ended, and sends a signal to the others if `number` is not 0.
  /// Returns false if there were none: one that was reaped may have left children to this process.
  bool visit_others(int number) const {
    bool left = false;
    for (const int child : children()) {
      if (child == pid_) continue;
      left = true;
      if (::waitpid(child, nullptr, WNOHANG) != child) ::kill(child, number);
    }
    return left;
  }

  /// Waits for the end of a child, which may leave children to this process, or for SIGTERM.
  void wait(Nanoseconds limit) {
    const timespec time{.tv_sec = limit / std::chrono::seconds{1},
                        .tv_nsec = (limit % std::chrono::seconds{1}).count()};
    node_ended_ |= ::sigtimedwait(&awaited_, nullptr, &time) == SIGTERM;
  }

  int pid_;
  sigset_t awaited_;
  siginfo_t end_{};
  bool left_others_ = false;
  bool node_ended_ = false;
};

/// A keeper must not keep the program's memory, sockets and output open.
void close_all_but(int status) {
  if (status > 0) ::close_range(0, static_cast<unsigned>(status) - 1, 0);
  ::close_range(static_cast<unsigned>(status) + 1, ~0U, 0);
}

/// Makes a child process that gets `signal` when its parent ends. Returns as fork() does.
int fork_below(int signal) {
  const int parent = ::getpid();
  const int pid = ::fork();
  if (pid != 0) return pid;
  ::prctl(PR_SET_PDEATHSIG, signal);
  if (::getppid() != parent) ::_exit(127);  // the parent ended before prctl() took effect
  return 0;
}

}  // namespace

int keep(int count, char** arguments) {
  int first = 5;  // the first variable of the environment
  while (first < count && std::strcmp(arguments[first], "--") != 0) ++first;
  if (first + 1 >= count) {
    std::fputs("takt-keeper is a part of Takt; only takt-node starts it\n", stderr);
    return 2;
  }
  const int failure = std::atoi(arguments[1]);
  const int status = std::atoi(arguments[2]);
  const int copy = std::atoi(arguments[3]);
  const bool others_stay = std::atoi(arguments[4]) != 0;
  for (const int fd : {failure, status}) ::fcntl(fd, F_SETFD, FD_CLOEXEC);
  if (copy >= 0 && !is_script(copy)) ::fcntl(copy, F_SETFD, FD_CLOEXEC);

  ::signal(SIGCHLD, SIG_DFL);  // if it were ignored, the kernel would reap the program
  sigset_t awaited;
  ::sigemptyset(&awaited);
  ::sigaddset(&awaited, SIGCHLD);
  ::sigaddset(&awaited, SIGTERM);
  ::sigprocmask(SIG_BLOCK, &awaited, nullptr);
  ::prctl(PR_SET_CHILD_SUBREAPER, 1);
  // Two keepers, so that the other one ends the program's processes if one is killed.
  int pid = fork_below(SIGTERM);
  if (pid > 0) {
    close_all_but(status);
    Keeper{pid, awaited}.guard();
    return 0;
  }
  if (pid == 0) {
    ::prctl(PR_SET_CHILD_SUBREAPER, 1);
    pid = fork_below(SIGKILL);
  }
  if (pid == 0) {
    ::setpgid(0, 0);
    ::sigprocmask(SIG_UNBLOCK, &awaited, nullptr);
    for (int i = 5; i < first; ++i) ::putenv(arguments[i]);
    char** const program = arguments + first + 1;
    if (copy >= 0)
      ::fexecve(copy, program, environ);
    else
      ::execv(*program, program);
  }
  if (pid <= 0) {
    const int number = errno;
    [[maybe_unused]] const auto written = ::write(failure, &number, sizeof number);
    ::_exit(127);
  }
  const KeptStart start{.pid = pid};
  [[maybe_unused]] auto written = ::write(status, &start, sizeof start);
  close_all_but(status);

  Keeper program{pid, awaited};
  program.wait_for_end();
  if (!others_stay) program.end_all();
  // If the other keeper was killed, close the pipe without a KeptEnd.
  if (const KeptEnd end = program.end(); !program.node_ended()) written = ::write(status, &end, sizeof end);
  program.wait_for_end_of_node();
  program.end_all();
  ::waitpid(pid, nullptr, 0);
  return 0;
}

void run_below_first_process() {
  if (::getpid() != 1) return;
  sigset_t all;
  sigset_t before;
  ::sigfillset(&all);
  ::sigprocmask(SIG_BLOCK, &all, &before);
  const int child = ::fork();
  if (child <= 0) {  // without a child, this process does the work itself, and does not reap
    ::sigprocmask(SIG_SETMASK, &before, nullptr);
    return;
  }
  while (true) {
    siginfo_t info{};
    const int number = ::sigwaitinfo(&all, &info);
    // Ctrl-C and other signals of the terminal reach the child too, except the end of the terminal (SIGHUP).
    const bool reaches_child = info.si_code == SI_KERNEL && number != SIGHUP;
    if (number > 0 && number != SIGCHLD && !reaches_child) ::kill(child, number);
    int status = 0;
    for (int ended = 0; (ended = ::waitpid(-1, &status, WNOHANG)) > 0;)
      if (ended == child) ::_exit(WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status));
  }
}

}  // namespace takt::os
