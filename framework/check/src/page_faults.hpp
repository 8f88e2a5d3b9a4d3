// Page faults, as the kernel signals or counts them.
#pragma once

namespace takt::check {

/// Of this process: makes ready for the signals. Once.
void serve_page_faults() noexcept;
/// Of the calling thread: from now on its faults are seen. Once a thread.
void watch_page_faults() noexcept;
/// Where faults have no place: records how many there were since it was called last, if these count. With a
/// system call then; else nothing.
void count_page_faults(bool these_count) noexcept;

}  // namespace takt::check
