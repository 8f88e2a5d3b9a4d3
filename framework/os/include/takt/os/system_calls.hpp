// Names of system calls.
#pragma once

#include <cstdint>
#include <string>

namespace takt::os {

/// Returns the name of a system call, for example "clock_nanosleep". If the number was not known when this
/// program was compiled, returns a text such as "system call 1000".
std::string system_call_name(std::int64_t number);

}  // namespace takt::os
