// Installs a signal handler that returns through this library's gate (system_calls.cpp). The return from a
// handler is a system call, and the kernel intercepts all system calls that are not made in the gate.
#pragma once

#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>

#if defined(__x86_64__)
extern "C" void takt_check_restorer();
#endif

namespace takt::check {

using SignalHandler = void (*)(int signal, siginfo_t* info, void* context);

inline void handle(int signal, SignalHandler handler) noexcept {
#if defined(__x86_64__)
  constexpr unsigned long kHasRestorer = 0x04000000;  // SA_RESTORER
  // The structure that the kernel expects (asm/signal.h). The C library's structure is different.
  struct {
    SignalHandler handler;
    unsigned long flags;
    void (*restorer)();
    std::uint64_t mask;
  } action{handler, SA_SIGINFO | SA_NODEFER | kHasRestorer, takt_check_restorer, 0};
  ::syscall(SYS_rt_sigaction, signal, &action, nullptr, sizeof action.mask);
#else
  struct sigaction action {};
  action.sa_sigaction = handler;
  action.sa_flags = SA_SIGINFO | SA_NODEFER;
  ::sigaction(signal, &action, nullptr);
#endif
}

}  // namespace takt::check
