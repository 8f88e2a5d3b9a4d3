// Finds the core dump of a process that a signal has just killed.
#pragma once

#include <string>
#include <string_view>

namespace takt::os {

/// Returns a glob() pattern that matches the core dumps of a process. `pattern` has the format of
/// /proc/sys/kernel/core_pattern. Parts of it whose value is not known here become "*".
std::string core_glob(std::string_view pattern, int pid, int signal);

struct CoreDump {
  std::string file;  ///< path of the core dump; empty if none was found
  std::string why;   ///< why none was found, for example "RLIMIT_CORE is 0"
};
/// Finds the core dump of a child process that this signal has just killed. The child must have had the same
/// resource limits and working folder as this process.
CoreDump find_core_dump(int pid, int signal);

}  // namespace takt::os
