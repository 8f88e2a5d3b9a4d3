// Finds the core dump of a process that a signal has just killed.
#pragma once

#include <string>
#include <string_view>

namespace takt::os {

/// A glob() pattern for the files of `pattern`, which is in the format of /proc/sys/kernel/core_pattern.
/// Parts that are not known here become "*".
std::string core_glob(std::string_view pattern, int pid, int signal);

struct CoreDump {
  std::string file;  ///< empty: there is none
  std::string why;   ///< "RLIMIT_CORE is 0": then
};
/// Of a child of ours that has ended by this signal just now, with our limits and in our folder.
CoreDump find_core_dump(int pid, int signal);

}  // namespace takt::os
