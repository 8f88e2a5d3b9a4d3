// Finds the core dump of a process that a signal has just killed.
#pragma once

#include <string>
#include <string_view>

namespace takt::os {

/// A glob() pattern for the files of `pattern`, which is in the format of /proc/sys/kernel/core_pattern.
/// Parts that are not known here become "*".
std::string core_glob(std::string_view pattern, int pid, int signal);

struct CoreDump {
  std::string file;  ///< path of the dump; empty: none was found
  std::string why;   ///< the reason if none was found: "RLIMIT_CORE is 0"
};
/// Finds the dump of a child process that this signal has just ended. The child must have had the resource
/// limits and the working folder of this process.
CoreDump find_core_dump(int pid, int signal);

}  // namespace takt::os
