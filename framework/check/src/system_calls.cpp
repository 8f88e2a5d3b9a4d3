#include "system_calls.hpp"

#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <ucontext.h>
#include <unistd.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "recorder.hpp"
#include "signal_handler.hpp"

#if defined(__x86_64__)

// linux/prctl.h of Debian 12 defines these constants; older versions do not.
#ifndef PR_SET_SYSCALL_USER_DISPATCH
#define PR_SET_SYSCALL_USER_DISPATCH 59
#define PR_SYS_DISPATCH_ON 1
#endif

// The gate is the only code whose system calls the kernel does not intercept. It contains
// takt_check_system_call(), which makes the intercepted calls, and takt_check_restorer(), with which signal
// handlers return. The unwinder recognizes takt_check_restorer() by its bytes.
extern "C" {
extern const char takt_check_gate[];      // NOLINT(modernize-avoid-c-arrays)
extern const char takt_check_gate_end[];  // NOLINT(modernize-avoid-c-arrays)
long takt_check_system_call(long number, const long* arguments);
void takt_check_restorer();
}
asm(R"(
.text
.globl takt_check_gate, takt_check_gate_end, takt_check_system_call, takt_check_restorer
.hidden takt_check_gate, takt_check_gate_end, takt_check_system_call, takt_check_restorer
takt_check_gate:
takt_check_system_call:
  movq %rdi, %rax
  movq %rsi, %r11
  movq 0(%r11), %rdi
  movq 8(%r11), %rsi
  movq 16(%r11), %rdx
  movq 24(%r11), %r10
  movq 32(%r11), %r8
  movq 40(%r11), %r9
  syscall
  ret
  nop
takt_check_restorer:
  movq $15, %rax
  syscall
  ud2  # a system call counts as at its return address, so this must be within the gate too
takt_check_gate_end:
)");

namespace takt::check {

namespace {

// The value of SYS_USER_DISPATCH, the si_code of a signal that reports an intercepted system call.
constexpr int kUserDispatch = 2;
constexpr int kInstruction = 2;  // length of the instruction `syscall`, in bytes

// Returns true if only the thread itself can make the system call. In a signal handler, such a call would
// have no effect or a wrong effect.
bool only_the_thread_can(int number) noexcept {
  switch (number) {
    case SYS_rt_sigreturn:
    case SYS_rt_sigprocmask:
    case SYS_sigaltstack:
    case SYS_clone:
    case SYS_clone3:
    case SYS_fork:
    case SYS_vfork:
    case SYS_execve:
    case SYS_execveat:
    case SYS_exit:
    case SYS_exit_group:
    case SYS_arch_prctl:
      return true;
    default:
      return false;
  }
}

void intercepted(int /*signal*/, siginfo_t* info, void* context) {
  if (info->si_code != kUserDispatch) return;
  auto& registers = static_cast<ucontext_t*>(context)->uc_mcontext.gregs;
  const int number = info->si_syscall;
  Pause pause;
  if (number != SYS_rt_sigreturn)
    record({.kind = channel::ViolationKind::system_call, .system_call = number});
  const std::array<long, 6> arguments{registers[REG_RDI], registers[REG_RSI], registers[REG_RDX],
                                      registers[REG_R10], registers[REG_R8],  registers[REG_R9]};
  if (!only_the_thread_can(number)) {
    registers[REG_RAX] = takt_check_system_call(number, arguments.data());
    return;
  }
  registers[REG_RIP] -= kInstruction;
  pause.goes_on();
}

}  // namespace

void serve_system_calls() noexcept { handle(SIGSYS, intercepted); }

void watch_system_calls() noexcept {
  const auto length = static_cast<std::size_t>(takt_check_gate_end - takt_check_gate);
  if (::prctl(PR_SET_SYSCALL_USER_DISPATCH, PR_SYS_DISPATCH_ON, takt_check_gate, length, selector()) != 0)
    is_blind(channel::ViolationLog::kNoSystemCalls);
}

}  // namespace takt::check

#else

namespace takt::check {

void serve_system_calls() noexcept {}
void watch_system_calls() noexcept { is_blind(channel::ViolationLog::kNoSystemCalls); }

}  // namespace takt::check

#endif
