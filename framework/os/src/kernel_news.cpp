#include <takt/os/kernel_news.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace takt::os {

KernelNews::KernelNews() : fd_(::open("/dev/kmsg", O_RDONLY | O_NONBLOCK | O_CLOEXEC)) {
  if (fd_ && ::lseek(fd_.get(), 0, SEEK_END) < 0) fd_.close();
}

std::optional<std::string> KernelNews::next() {
  std::array<char, 8192> record{};  // the maximum size of a record of the kernel
  while (fd_) {
    const ssize_t n = ::read(fd_.get(), record.data(), record.size());
    if (n > 0) return kernel_text({record.data(), static_cast<std::size_t>(n)});
    if (n < 0 && (errno == EINTR || errno == EPIPE))
      // EPIPE means that the kernel has overwritten records before this process read them.
      continue;
    break;
  }
  return std::nullopt;
}

std::string kernel_text(const std::string& record) {
  const std::size_t begin = record.find(';');
  if (begin == std::string::npos) return {};
  return record.substr(begin + 1, record.find('\n', begin) - begin - 1);
}

}  // namespace takt::os
