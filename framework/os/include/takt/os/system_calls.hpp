// What system calls are called.
#pragma once

#include <cstdint>
#include <string>

namespace takt::os {

/// "clock_nanosleep"; "system call 1000" for a number that had no name when this was compiled.
std::string system_call_name(std::int64_t number);

}  // namespace takt::os
