#include <takt/os/fd.hpp>

#include <dirent.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "error.hpp"

namespace takt::os {

void Fd::close() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

std::vector<int> open_descriptors() {
  std::vector<int> found;
  DIR* const folder = ::opendir("/proc/self/fd");
  if (folder == nullptr) return found;
  while (const dirent* const entry = ::readdir(folder)) {
    if (const int fd = std::atoi(entry->d_name); entry->d_name[0] != '.' && fd != ::dirfd(folder))
      found.push_back(fd);
  }
  ::closedir(folder);
  return found;
}

Problem error_problem(std::string call, int error, std::string fix) {
  // EMFILE means that the process has too many open files, whatever the call was. So the caller's `fix` does
  // not help.
  if (error == EMFILE)
    fix =
        "raise the limit on open files of this process: ulimit -n, prlimit --nofile or, for a service, "
        "LimitNOFILE=";
  return fail(std::move(call) + ": " + std::strerror(error), std::move(fix));
}

std::string advice_to_write(int error) {
  switch (error) {
    case EACCES:
    case EPERM:
    case EROFS:
      return "name a folder that this user may write to";
    case ENOSPC:
    case EDQUOT:
      return "free space on its disk, or name a folder on another disk";
    case ENOTDIR:
    case EEXIST:
      return "a file stands where a folder is needed: name another folder";
    case EISDIR:
      return "name a file, not a folder";
    default:
      return "name another folder";
  }
}

Problem errno_problem(std::string call, std::string fix) {
  return error_problem(std::move(call), errno, std::move(fix));
}

}  // namespace takt::os
