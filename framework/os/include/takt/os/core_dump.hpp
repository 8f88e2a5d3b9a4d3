// Where the kernel leaves the memory of a process that it has just killed.
#pragma once

#include <string>
#include <string_view>

namespace takt::os {

/// The names that `pattern` (as /proc/sys/kernel/core_pattern has it) may stand for, for glob(): what is not
/// known here is "*".
std::string core_glob(std::string_view pattern, int pid, int signal);

struct CoreDump {
  std::string file;  ///< empty: there is none
  std::string why;   ///< "RLIMIT_CORE is 0": then
};
/// Of a child of ours that has ended by this signal just now, with our limits and in our folder.
CoreDump find_core_dump(int pid, int signal);

}  // namespace takt::os
