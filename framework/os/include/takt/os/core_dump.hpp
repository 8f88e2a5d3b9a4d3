// Finds the core dump of a process that a signal has just killed.
#pragma once

#include <string>
#include <string_view>

namespace takt::os {

/// Returns a glob() pattern that matches the core dumps of process `pid`, which `signal` has killed.
/// `pattern` has the format of /proc/sys/kernel/core_pattern. Each part of the pattern whose value this
/// function does not know becomes "*".
std::string core_glob(std::string_view pattern, int pid, int signal);

struct CoreDump {
  std::string file;  ///< path of the core dump; empty if none was found
  std::string why;   ///< why there is no core dump, for example "RLIMIT_CORE is 0"
};
/// Finds the core dump of the child process `pid`, which `signal` has just killed. The child must have had
/// the same resource limits and working folder as this process.
CoreDump find_core_dump(int pid, int signal);

}  // namespace takt::os
