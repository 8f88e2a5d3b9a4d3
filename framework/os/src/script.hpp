#pragma once

#include <unistd.h>

#include <array>

namespace takt::os {

/// Returns whether a file is a script. Its interpreter then reads the script from the descriptor, so the
/// descriptor must survive exec.
inline bool is_script(int fd) {
  std::array<char, 2> begin{};
  return ::pread(fd, begin.data(), begin.size(), 0) == 2 && begin[0] == '#' && begin[1] == '!';
}

}  // namespace takt::os
