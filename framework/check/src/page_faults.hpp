// Detects page faults with signals or counters of the kernel.
#pragma once

namespace takt::check {

/// Installs this process's signal handler for page faults. Call it once.
void serve_page_faults() noexcept;
/// Starts to detect page faults of the calling thread. Call it once per thread.
void watch_page_faults() noexcept;
/// Counts the page faults of the calling thread since the last call, and records their number if
/// `these_count` is true. Makes one system call. Does nothing if the kernel signals each page fault with its
/// location.
void count_page_faults(bool these_count) noexcept;

}  // namespace takt::check
