// System calls, as the kernel hands them over.
#pragma once

namespace takt::check {

/// Of this process: makes ready for what the kernel will hand over. Once.
void serve_system_calls() noexcept;
/// Of the calling thread: from now on its system calls are handed over while they count. Once a thread.
void watch_system_calls() noexcept;

}  // namespace takt::check
