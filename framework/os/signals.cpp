#include <takt/os/signals.hpp>

#include <poll.h>
#include <signal.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <memory>

#include <takt/os/error.hpp>

namespace takt::os {

namespace {

CrashHandler crash_handler = nullptr;

void crashed(int signal) {
  if (crash_handler != nullptr) crash_handler(signal);
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

}  // namespace

Result<SignalQueue> SignalQueue::of_requests_to_end() {
  sigset_t set;
  ::sigemptyset(&set);
  for (int signal : {SIGINT, SIGTERM, SIGHUP}) ::sigaddset(&set, signal);
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
  SignalQueue queue;
  queue.fd_ = Fd{::signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK)};
  if (!queue.fd_) return errno_problem("signalfd", "free file descriptors");
  return queue;
}

std::optional<int> SignalQueue::next() const {
  signalfd_siginfo info{};
  if (::read(fd_.get(), &info, sizeof info) != sizeof info) return std::nullopt;
  return static_cast<int>(info.ssi_signo);
}

void survive_broken_pipes() { ::signal(SIGPIPE, SIG_IGN); }

bool wait_readable(const std::vector<const Fd*>& fds, int limit_ms) {
  std::vector<pollfd> wanted;
  wanted.reserve(fds.size());
  for (const Fd* fd : fds) {
    if (*fd) wanted.push_back({.fd = fd->get(), .events = POLLIN, .revents = 0});
  }
  return ::poll(wanted.data(), wanted.size(), limit_ms) > 0;
}

void on_crash(CrashHandler handler) {
  crash_handler = handler;
  struct sigaction action {};
  action.sa_handler = crashed;
  action.sa_flags = static_cast<int>(SA_ONSTACK | SA_RESETHAND | SA_NODEFER);
  for (int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT}) ::sigaction(signal, &action, nullptr);
}

void prepare_crash_stack() {
#ifndef __SANITIZE_ADDRESS__  // which gives each thread one, and at its end unmaps whichever it finds
  constexpr std::size_t kBytes = 64 * 1024;
  thread_local std::unique_ptr<std::array<char, kBytes>> stack;
  if (stack) return;
  stack = std::make_unique<std::array<char, kBytes>>();
  const stack_t alternate{.ss_sp = stack->data(), .ss_flags = 0, .ss_size = kBytes};
  ::sigaltstack(&alternate, nullptr);
#endif
}

}  // namespace takt::os
