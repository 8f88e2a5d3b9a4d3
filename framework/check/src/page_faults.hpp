// Detects page faults with the kernel's signals or counters.
#pragma once

namespace takt::check {

/// Installs the signal handler of this process. Call it once.
void serve_page_faults() noexcept;
/// From now on, faults of the calling thread are detected. Call it once per thread.
void watch_page_faults() noexcept;
/// Counts the faults since the last call, if the kernel does not report their location. Records their number
/// if `these_count` is true. This costs a system call. If the kernel reports the location, does nothing.
void count_page_faults(bool these_count) noexcept;

}  // namespace takt::check
