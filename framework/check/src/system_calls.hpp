// Intercepts and records the system calls of modules, with the kernel's Syscall User Dispatch.
#pragma once

namespace takt::check {

/// Installs this process's signal handler for intercepted system calls. Call it once.
void serve_system_calls() noexcept;
/// From now on, makes the kernel intercept the system calls of the calling thread while counts() returns
/// true. Call this once per thread.
void watch_system_calls() noexcept;

}  // namespace takt::check
