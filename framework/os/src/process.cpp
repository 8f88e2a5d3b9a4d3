#include <takt/os/process.hpp>

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

#include <takt/core/time.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/keeper.hpp>
#include "error.hpp"
#include "script.hpp"

extern char** environ;  // NOLINT(readability-redundant-declaration)

namespace takt::os {

namespace {

struct Pipe {
  Fd read;
  Fd write;
};

Result<Pipe> make_pipe() {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) return errno_problem("pipe", "free file descriptors");
  return Pipe{Fd{ends[0]}, Fd{ends[1]}};
}

ProcessEnd ended(int status) {
  if (WIFSIGNALED(status)) return {.signalled = true, .code = WTERMSIG(status)};
  return {.signalled = false, .code = WEXITSTATUS(status)};
}

/// The time from the report of a child's end until the child is reaped. By then, the child's last thread has
/// normally ended.
constexpr Nanoseconds kReapAfter = std::chrono::seconds{1};

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> result;
  result.reserve(texts.size() + 1);
  for (std::string& text : texts) result.push_back(text.data());
  result.push_back(nullptr);
  return result;
}

std::vector<std::string> with_environment(const std::vector<std::pair<std::string, std::string>>& added) {
  std::vector<std::string> texts;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text{*entry};
    bool replaced = false;
    for (const auto& [name, value] : added) replaced |= text.starts_with(name + "=");
    if (!replaced) texts.emplace_back(text);
  }
  for (const auto& [name, value] : added) texts.push_back(name + "=" + value);
  return texts;
}

}  // namespace

const int kTerminate = SIGTERM;
const int kKill = SIGKILL;

std::string signal_text(int signal) {
  const char* name = ::sigabbrev_np(signal);
  if (name == nullptr) return "signal " + std::to_string(signal);
  return std::string{"SIG"} + name + " (" + ::sigdescr_np(signal) + ")";
}

std::string ProcessEnd::text() const {
  if (signalled)
    return "was killed by " + signal_text(code) +
           (keeper_killed ? ", because its takt-keeper was killed" : "");
  return "ended with status " + std::to_string(code) +
         (left_others ? ", while processes that it had started still ran" : "");
}

Child::Child(Child&& other) noexcept
    : output(std::move(other.output)),
      error(std::move(other.error)),
      pid_(std::exchange(other.pid_, 0)),
      keeper_(std::exchange(other.keeper_, 0)),
      others_stay_(other.others_stay_),
      kept_(std::move(other.kept_)),
      zombie_(std::exchange(other.zombie_, 0)),
      reap_at_(other.reap_at_) {}

Child& Child::operator=(Child&& other) noexcept {
  std::swap(output, other.output);
  std::swap(error, other.error);
  std::swap(pid_, other.pid_);
  std::swap(keeper_, other.keeper_);
  std::swap(others_stay_, other.others_stay_);
  std::swap(kept_, other.kept_);
  return *this;
}

Child::~Child() {
  reap();
  if (running()) {
    signal(SIGKILL);
    wait();
  }
  if (keeper_ != 0) end_keeper();
}

namespace {

/// Returns the interpreter that the first line of a script names; empty if the file is not a script.
std::string interpreter_of(const std::string& program) {
  std::ifstream file{program};
  std::string line;
  std::getline(file, line);
  if (!line.starts_with("#!")) return {};
  const std::size_t begin = line.find_first_not_of(" \t", 2);
  if (begin == std::string::npos) return {};
  return line.substr(begin, line.find_first_of(" \t\r", begin) - begin);
}

}  // namespace

Result<Child> Child::spawn(const SpawnOptions& options) {
  // A successful exec closes this pipe. If exec fails, the child writes the error number to it.
  auto failure = make_pipe();
  if (!failure) return failure.problems();
  Pipe kept;
  if (options.whole_tree) {
    auto pipe = make_pipe();
    if (!pipe) return pipe.problems();
    kept = std::move(*pipe);
  }
  Pipe output;
  Pipe error;
  if (options.capture_output) {
    auto first = make_pipe();
    auto second = make_pipe();
    if (!first) return first.problems();
    if (!second) return second.problems();
    output = std::move(*first);
    error = std::move(*second);
  }

  // The child must not allocate memory after fork(), so everything is allocated before the fork.
  std::vector<std::string> arguments;
  if (options.whole_tree) {
    arguments = {private_directory() + "/takt-keeper", std::to_string(failure->write.get()),
                 std::to_string(kept.write.get()),
                 std::to_string(options.copy != nullptr ? options.copy->get() : -1),
                 options.others_stay ? "1" : "0"};
    // Not in the environment of takt-keeper: libtakt_check.so must check the program, not takt-keeper.
    for (const auto& [name, value] : options.environment) arguments.push_back(name + "=" + value);
    arguments.emplace_back("--");
  }
  arguments.push_back(options.program);
  arguments.insert(arguments.end(), options.arguments.begin(), options.arguments.end());
  std::vector<std::string> environment =
      options.whole_tree ? with_environment({}) : with_environment(options.environment);
  const std::vector<char*> argv = pointers(arguments);
  const std::vector<char*> envp = pointers(environment);
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  for (const int cpu : options.cpus) CPU_SET(static_cast<unsigned>(cpu), &cpus);
  const int parent = ::getpid();
  const bool keeps_copy = options.copy != nullptr && (options.whole_tree || is_script(options.copy->get()));

  const int pid = ::fork();
  if (pid < 0) return errno_problem("fork", "free memory or raise the limit on processes");
  if (pid == 0) {
    const auto give_up = [&failure] {
      const int number = errno;
      [[maybe_unused]] const auto written = ::write(failure->write.get(), &number, sizeof number);
      ::_exit(127);
    };
    if (options.dies_with_parent) {
      ::prctl(PR_SET_PDEATHSIG, options.whole_tree ? SIGTERM : SIGKILL);
      if (::getppid() != parent) ::_exit(127);  // the parent ended before prctl() took effect
    }
    if (options.new_group) ::setpgid(0, 0);
    if (!options.cpus.empty()) ::sched_setaffinity(0, sizeof cpus, &cpus);
    if (options.capture_output) {
      ::dup2(output.write.get(), STDOUT_FILENO);
      ::dup2(error.write.get(), STDERR_FILENO);
      const int nothing = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
      ::dup2(nothing, STDIN_FILENO);
    }
    // Libraries such as Fast DDS open sockets that survive exec. So mark all descriptors close-on-exec, and
    // then unmark those that the program inherits.
    if (::close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC) != 0) give_up();
    for (const Fd* fd : options.inherit) ::fcntl(fd->get(), F_SETFD, 0);
    if (keeps_copy) ::fcntl(options.copy->get(), F_SETFD, 0);
    sigset_t none;
    ::sigemptyset(&none);
    ::sigprocmask(SIG_SETMASK, &none, nullptr);
    ::signal(SIGPIPE, SIG_DFL);  // otherwise the new program would ignore the signal, too
    if (options.whole_tree) {
      for (const Fd* fd : {&failure->write, &kept.write}) ::fcntl(fd->get(), F_SETFD, 0);
      ::execve(argv[0], argv.data(), envp.data());
      errno = -errno;  // not an error of the program
    } else if (options.copy != nullptr) {
      ::fexecve(options.copy->get(), argv.data(), envp.data());
    } else {
      ::execve(options.program.c_str(), argv.data(), envp.data());
    }
    give_up();
  }

  Child child;
  child.others_stay_ = options.others_stay;
  (options.whole_tree ? child.keeper_ : child.pid_) = pid;
  failure->write.close();
  kept.write.close();
  int number = 0;
  ssize_t got = 0;
  do {
    got = ::read(failure->read.get(), &number, sizeof number);
  } while (got < 0 && errno == EINTR);
  if (got == sizeof number) {
    if (child.keeper_ != 0)
      child.end_keeper();
    else
      child.wait();
    if (number < 0) return error_problem(private_directory() + "/takt-keeper", -number, "install Takt again");
    if (const std::string interpreter = number == ENOENT ? interpreter_of(options.program) : "";
        !interpreter.empty() && ::access(interpreter.c_str(), F_OK) != 0)
      return fail(options.program + " needs the interpreter " + interpreter + ", which does not exist",
                  "install it, or correct the first line of the script");
    return error_problem(options.program, number,
                         "name a program that this user may execute on this machine");
  }
  if (child.keeper_ != 0) {
    KeptStart start;
    if (::read(kept.read.get(), &start, sizeof start) != sizeof start) {
      child.end_keeper();
      return fail("takt-keeper ended before it started " + options.program, "try again");
    }
    child.pid_ = start.pid;
    child.kept_ = std::move(kept.read);
    ::fcntl(child.kept_.get(), F_SETFL, O_NONBLOCK);
  }
  child.output = std::move(output.read);
  child.error = std::move(error.read);
  for (const Fd* fd : {&child.output, &child.error}) {
    if (*fd) ::fcntl(fd->get(), F_SETFL, O_NONBLOCK);
  }
  return child;
}

std::optional<ProcessEnd> Child::poll() noexcept {
  if (zombie_ != 0 && now() >= reap_at_ && ::waitpid(zombie_, nullptr, WNOHANG) != 0) zombie_ = 0;
  if (!running()) return std::nullopt;
  if (keeper_ != 0) {
    const auto end = kept_end();
    if (!end) return std::nullopt;
    pid_ = 0;
    if (others_stay_) return end;
    reap();
    ::kill(keeper_, SIGTERM);
    zombie_ = std::exchange(keeper_, 0);
    reap_at_ = now() + kReapAfter;
    return end;
  }
  siginfo_t info{};
  if (::waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0 ||
      info.si_pid != pid_) {
    return std::nullopt;
  }
  reap();
  zombie_ = std::exchange(pid_, 0);
  reap_at_ = now() + kReapAfter;
  return ProcessEnd{.signalled = info.si_code != CLD_EXITED, .code = info.si_status};
}

std::optional<ProcessEnd> Child::kept_end() noexcept {
  KeptEnd end;
  const ssize_t got = ::read(kept_.get(), &end, sizeof end);
  if (got < 0 && (errno == EAGAIN || errno == EINTR)) return std::nullopt;
  if (got != sizeof end) return ProcessEnd{.signalled = true, .code = SIGKILL, .keeper_killed = true};
  return ProcessEnd{.signalled = end.signalled != 0, .code = end.code, .left_others = end.left_others != 0};
}

void Child::end_keeper() noexcept {
  ::kill(keeper_, SIGTERM);
  while (::waitpid(keeper_, nullptr, 0) < 0 && errno == EINTR) {
  }
  keeper_ = 0;
}

void Child::reap() noexcept {
  if (zombie_ != 0) ::waitpid(std::exchange(zombie_, 0), nullptr, 0);
}

ProcessEnd Child::wait() noexcept {
  if (keeper_ != 0) {
    std::optional<ProcessEnd> end;
    while (!(end = kept_end())) {
      pollfd wanted{.fd = kept_.get(), .events = POLLIN, .revents = 0};
      ::poll(&wanted, 1, -1);
    }
    end_keeper();
    pid_ = 0;
    return *end;
  }
  int status = 0;
  while (running() && ::waitpid(pid_, &status, 0) < 0 && errno == EINTR) {
  }
  pid_ = 0;
  return ended(status);
}

void Child::signal(int number) const noexcept {
  if (!running()) return;
  if (keeper_ == 0 || ::kill(-pid_, number) != 0) ::kill(pid_, number);
}

void Child::signal_thread(int thread, int number) const noexcept {
  if (running()) ::tgkill(pid_, thread, number);
}

std::string read_available(const Fd& fd, bool* end) {
  std::string text;
  std::array<char, 4096> buffer{};
  // Read only a limited number of bytes, so that a child that writes without pause cannot hold this thread
  // up.
  while (text.size() < 16 * buffer.size()) {
    const ssize_t n = ::read(fd.get(), buffer.data(), buffer.size());
    if (n < 0 && errno == EINTR) continue;
    if (n == 0 || (n < 0 && errno != EAGAIN)) *end = true;
    if (n <= 0) break;
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
  return text;
}

Result<std::string> in_child(const std::string& what, const std::function<std::string()>& work,
                             Nanoseconds limit) {
  auto pipe = make_pipe();
  if (!pipe) return pipe.problems();
  const int pid = ::fork();
  if (pid < 0) return errno_problem("fork", "free memory or raise the limit on processes");
  if (pid == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    // The output of foreign code must not mix with the output of this process.
    const int nothing = ::open("/dev/null", O_RDWR | O_CLOEXEC);
    ::dup2(nothing, STDOUT_FILENO);
    ::dup2(nothing, STDERR_FILENO);
    const std::string text = work();
    std::size_t sent = 0;
    while (sent < text.size()) {
      const ssize_t n = ::write(pipe->write.get(), text.data() + sent, text.size() - sent);
      if (n <= 0) ::_exit(126);
      sent += static_cast<std::size_t>(n);
    }
    ::_exit(0);
  }
  pipe->write.close();
  std::string text;
  const Instant end_at = now() + limit;
  bool late = false;
  std::array<char, 4096> buffer{};
  while (true) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(end_at - now()).count();
    pollfd wanted{.fd = pipe->read.get(), .events = POLLIN, .revents = 0};
    const int ready = left > 0 ? ::poll(&wanted, 1, static_cast<int>(left)) : 0;
    if (ready < 0 && errno == EINTR) continue;
    late = ready == 0;
    if (late) break;
    const ssize_t n = ::read(pipe->read.get(), buffer.data(), buffer.size());
    if (n <= 0) break;
    text.append(buffer.data(), static_cast<std::size_t>(n));
  }
  if (late) ::kill(pid, SIGKILL);
  int status = 0;
  while (::waitpid(pid, &status, 0) < 0 && errno == EINTR) {
  }
  const ProcessEnd end = ended(status);
  if (late) return fail(what + " did not end within " + takt::to_text(limit));
  if (end.signalled || end.code != 0) return fail(what + " " + end.text());
  return text;
}

std::string program_directory() {
  std::array<char, PATH_MAX> path{};
  const ssize_t n = ::readlink("/proc/self/exe", path.data(), path.size() - 1);
  const std::string text{path.data(), n > 0 ? static_cast<std::size_t>(n) : 0};
  return text.substr(0, text.find_last_of('/'));
}

std::string private_directory() {
  const std::filesystem::path programs = program_directory();
  std::error_code error;
  const auto installed = std::filesystem::canonical(programs / TAKT_PRIVATE_FROM_PROGRAMS, error);
  return error ? programs.string() : installed.string();
}

}  // namespace takt::os
