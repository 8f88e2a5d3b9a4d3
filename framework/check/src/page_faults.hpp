// Detects page faults by the kernel's signals or counters.
#pragma once

namespace takt::check {

/// Installs the signal handler of this process. Call it once.
void serve_page_faults() noexcept;
/// From now on, faults of the calling thread are detected. Call it once per thread.
void watch_page_faults() noexcept;
/// If the kernel gives no place for faults: records the number of faults since the last call if
/// `these_count`, at the cost of a system call. Otherwise does nothing.
void count_page_faults(bool these_count) noexcept;

}  // namespace takt::check
