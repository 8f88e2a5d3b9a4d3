// Detects page faults by the kernel's signals or counters.
#pragma once

namespace takt::check {

/// Installs the signal handler of this process. Call it once.
void serve_page_faults() noexcept;
/// From now on, faults of the calling thread are detected. Call it once per thread.
void watch_page_faults() noexcept;
/// If the kernel does not report the location of faults: counts the faults since the last call, and records
/// their number if `these_count`; costs a system call. Otherwise does nothing.
void count_page_faults(bool these_count) noexcept;

}  // namespace takt::check
