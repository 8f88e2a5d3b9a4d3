#include <takt/os/signals.hpp>

#include <cxxabi.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <link.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/signalfd.h>
#include <ucontext.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <climits>
#include <cstdlib>
#include <exception>
#include <memory>
#include <string>
#include <typeinfo>

#include "error.hpp"

namespace takt::os {

const int kHangSignal = SIGSTKFLT;  // neither Linux nor common libraries use it; its default ends the process

namespace {

CrashHandler crash_handler = nullptr;

std::uintptr_t place_of_crash(const void* context) noexcept {
  const auto& machine = static_cast<const ucontext_t*>(context)->uc_mcontext;
#if defined(__x86_64__)
  return static_cast<std::uintptr_t>(machine.gregs[REG_RIP]);
#elif defined(__aarch64__)
  return static_cast<std::uintptr_t>(machine.pc);
#else
  static_cast<void>(machine);
  return 0;
#endif
}

void crashed(int signal, siginfo_t*, void* context) {
  if (crash_handler != nullptr) crash_handler(signal, place_of_crash(context), nullptr);
  ::signal(signal, SIG_DFL);
  ::raise(signal);
}

/// Returns the type of the exception that is being handled, as in C++.
std::string type_of_exception() {
  const char* const name = abi::__cxa_current_exception_type()->name();
  int status = 0;
  const std::unique_ptr<char, void (*)(void*)> type{abi::__cxa_demangle(name, nullptr, nullptr, &status),
                                                    std::free};
  return type != nullptr ? type.get() : name;
}

// Called by std::terminate(), for example when an exception leaves a function that is noexcept.
[[noreturn]] void terminated() noexcept {
  const auto at = reinterpret_cast<std::uintptr_t>(__builtin_return_address(0));
  if (std::current_exception() != nullptr) {
    try {
      throw;
    } catch (const std::exception& exception) {
      crash_handler(SIGABRT, at, exception.what());
    } catch (...) {
      crash_handler(SIGABRT, at, (type_of_exception() + " (not a std::exception)").c_str());
    }
  }
  std::abort();
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

void block_user_signals() {
  sigset_t set;
  ::sigemptyset(&set);
  for (int signal : {SIGALRM, SIGVTALRM, SIGPROF, SIGIO, SIGUSR1, SIGUSR2}) ::sigaddset(&set, signal);
  for (int signal = SIGRTMIN; signal <= SIGRTMAX; ++signal) ::sigaddset(&set, signal);
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

bool wait_readable(const std::vector<const Fd*>& fds, int limit_ms) {
  std::vector<pollfd> wanted;
  wanted.reserve(fds.size());
  for (const Fd* fd : fds) {
    if (*fd) wanted.push_back({.fd = fd->get(), .events = POLLIN, .revents = 0});
  }
  return ::poll(wanted.data(), wanted.size(), limit_ms) > 0;
}

std::size_t write_to_standard_error(std::string_view text, int limit_ms) noexcept {
  pollfd ready{.fd = STDERR_FILENO, .events = POLLOUT, .revents = 0};
  if (::poll(&ready, 1, limit_ms) <= 0) return 0;
  // A pipe that is ready takes at least PIPE_BUF bytes.
  const ssize_t written = ::write(STDERR_FILENO, text.data(), std::min<std::size_t>(text.size(), PIPE_BUF));
  if (written < 0) return errno == EAGAIN || errno == EINTR ? 0 : text.size();
  return static_cast<std::size_t>(written);
}

void on_crash(CrashHandler handler) {
  // The first call of backtrace() loads a library and allocates memory. So make this call now, not in a
  // crash.
  std::array<void*, 2> frames{};
  ::backtrace(frames.data(), frames.size());
  crash_handler = handler;
  std::set_terminate(terminated);
  static_cast<void>(take_back_crashes());
}

std::string take_back_crashes() {
  struct sigaction action {};
  action.sa_sigaction = crashed;
  action.sa_flags = static_cast<int>(SA_ONSTACK | SA_RESETHAND | SA_NODEFER | SA_SIGINFO);
  std::string replaced;
  for (int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE, SIGABRT, kHangSignal}) {
    struct sigaction before {};
    ::sigaction(signal, &action, &before);
    if (before.sa_sigaction == crashed) continue;
    replaced += (replaced.empty() ? "SIG" : ", SIG") + std::string{::sigabbrev_np(signal)};
  }
  return replaced;
}

void walk_stack(std::uintptr_t at, std::size_t most, void (*found)(const CodeAt&) noexcept) noexcept {
  const auto report = [found](std::uintptr_t address, std::uintptr_t back) {
    dl_find_object object{};
    if (::_dl_find_object(reinterpret_cast<void*>(address), &object) != 0) return found({address, "?"});
    const link_map* map = object.dlfo_link_map;
    found({address - map->l_addr - back, map->l_name});
  };
  // The first frames are those of this function and of the signal handler. If the list does not contain the
  // address of the crash (after a call of an invalid function pointer), only this address is reported.
  constexpr std::size_t kOwn = 8;
  constexpr std::size_t kMost = 64;
  std::array<void*, kMost + kOwn> frames{};
  report(at, 0);
  const int all = ::backtrace(frames.data(), static_cast<int>(std::min(most + kOwn, frames.size())));
  void* const* const end = frames.data() + all;
  void* const* frame = std::find(frames.data(), frames.data() + all, reinterpret_cast<void*>(at));
  if (frame == end) return;
  // A return address points behind the call instruction, so subtract 1.
  for (std::size_t reported = 1; ++frame != end && reported < most; ++reported)
    report(reinterpret_cast<std::uintptr_t>(*frame), 1);
}

void prepare_crash_stack() {
  // If a signal is blocked, the kernel ends the process at once. The C library blocks all signals in the
  // threads of timers.
  sigset_t crashes;
  ::sigemptyset(&crashes);
  for (const int signal : {SIGSEGV, SIGBUS, SIGILL, SIGFPE}) ::sigaddset(&crashes, signal);
  ::pthread_sigmask(SIG_UNBLOCK, &crashes, nullptr);
#ifndef __SANITIZE_ADDRESS__  // the sanitizer itself gives each thread such a stack
  constexpr std::size_t kBytes = 64 * 1024;
  thread_local std::unique_ptr<std::array<char, kBytes>> stack;
  if (stack) return;
  stack = std::make_unique<std::array<char, kBytes>>();
  const stack_t alternate{.ss_sp = stack->data(), .ss_flags = 0, .ss_size = kBytes};
  ::sigaltstack(&alternate, nullptr);
#endif
}

}  // namespace takt::os
