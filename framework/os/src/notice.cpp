#include <takt/os/notice.hpp>

#include <sys/eventfd.h>
#include <unistd.h>

#include <cstdint>

#include "error.hpp"

namespace takt::os {

Result<Notice> Notice::create() {
  Notice notice;
  notice.fd_ = Fd{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};
  if (!notice.fd_) return errno_problem("eventfd", "free file descriptors");
  return notice;
}

void Notice::give() const noexcept {
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(fd_.get(), &one, sizeof one);
}

bool Notice::take() const noexcept {
  std::uint64_t count = 0;
  return ::read(fd_.get(), &count, sizeof count) == sizeof count;
}

}  // namespace takt::os
