// Names of system calls, and calls that do not pass through the C library.
#pragma once

#include <cstdint>
#include <string>

namespace takt::os {

/// Returns the name of a system call, for example "clock_nanosleep". If the number was not known when this
/// program was compiled, returns a text such as "system call 1000".
std::string system_call_name(std::int64_t number);

/// Ends this process at once, as _exit() does, even if this program replaces _exit(). Async-signal-safe.
[[noreturn]] void end_process(int status) noexcept;

}  // namespace takt::os
