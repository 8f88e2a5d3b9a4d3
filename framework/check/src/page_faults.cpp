#include "page_faults.hpp"

#include <linux/perf_event.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdint>

#include "recorder.hpp"
#include "signal_handler.hpp"

namespace takt::check {

namespace {

// The value of TRAP_PERF, the si_code of a signal that reports a performance event.
constexpr int kFromPerf = 6;

thread_local bool only_counted = false;
thread_local std::uint64_t counted = 0;

void faulted(int signal, siginfo_t* info, void* /*context*/) {
  if (info->si_code != kFromPerf) {  // caused by a breakpoint without a debugger, not by a page fault
    ::signal(signal, SIG_DFL);
    ::raise(signal);
    return;
  }
  if (!counts()) return;
  const Pause pause;
  record({.kind = channel::ViolationKind::page_fault, .exact = true});
}

}  // namespace

void serve_page_faults() noexcept { handle(SIGTRAP, faulted); }

void watch_page_faults() noexcept {
  perf_event_attr wanted{};
  wanted.size = sizeof wanted;
  wanted.type = PERF_TYPE_SOFTWARE;
  wanted.config = PERF_COUNT_SW_PAGE_FAULTS;
  wanted.sample_period = 1;
  wanted.exclude_kernel = 1;
  wanted.exclude_hv = 1;
  wanted.sigtrap = 1;
  wanted.remove_on_exec = 1;
  // The file descriptor stays open until the process ends, because the watched threads run until then.
  const long fd = ::syscall(SYS_perf_event_open, &wanted, 0, -1, -1, PERF_FLAG_FD_CLOEXEC);
  only_counted = fd < 0;
  if (only_counted) is_blind(channel::ViolationLog::kNoFaultPlaces);
}

void count_page_faults(bool these_count) noexcept {
  if (!only_counted) return;
  rusage usage{};
  ::getrusage(RUSAGE_THREAD, &usage);
  const auto now = static_cast<std::uint64_t>(usage.ru_minflt + usage.ru_majflt);
  const std::uint64_t times = now - counted;
  counted = now;
  if (these_count && times != 0)
    record({.kind = channel::ViolationKind::page_fault, .times = times, .placed = false});
}

}  // namespace takt::check
