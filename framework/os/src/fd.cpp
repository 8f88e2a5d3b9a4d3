#include <takt/os/fd.hpp>

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "error.hpp"

namespace takt::os {

void Fd::close() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
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

Problem errno_problem(std::string call, std::string fix) {
  return error_problem(std::move(call), errno, std::move(fix));
}

}  // namespace takt::os
