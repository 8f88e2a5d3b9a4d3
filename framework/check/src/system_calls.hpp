// Intercepts system calls with the help of the kernel.
#pragma once

namespace takt::check {

/// Installs the signal handler of this process. Call it once.
void serve_system_calls() noexcept;
/// From now on, system calls of the calling thread are intercepted while they count. Call it once per thread.
void watch_system_calls() noexcept;

}  // namespace takt::check
