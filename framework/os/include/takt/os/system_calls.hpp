// Names of system calls.
#pragma once

#include <cstdint>
#include <string>

namespace takt::os {

/// The name of a system call: "clock_nanosleep"; "system call 1000" for a number unknown at compile time.
std::string system_call_name(std::int64_t number);

}  // namespace takt::os
