#include <takt/os/wake_signal.hpp>

#include <signal.h>

#include <cerrno>

namespace takt::os {

namespace {
sigset_t wake_signal() noexcept {
  sigset_t set;
  ::sigemptyset(&set);
  ::sigaddset(&set, SIGRTMIN);
  return set;
}
}  // namespace

void hold_wake_signal() noexcept {
  const sigset_t set = wake_signal();
  ::pthread_sigmask(SIG_BLOCK, &set, nullptr);
}

void wait_for_wake_signal() noexcept {
  const sigset_t set = wake_signal();
  while (::sigwaitinfo(&set, nullptr) < 0 && errno == EINTR) {
  }
}

void send_wake_signal(int pid) noexcept { ::kill(pid, SIGRTMIN); }

}  // namespace takt::os
