#include <takt/os/sealed_copy.hpp>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>

#include "error.hpp"

namespace takt::os {

namespace {

// Some Linux systems allow the execution of a memfd only if it was created with this flag. Linux before 6.3
// does not know the flag.
#ifdef MFD_EXEC
constexpr unsigned kMayExecute = MFD_EXEC;
#else
constexpr unsigned kMayExecute = 0x10;
#endif

Fd memory_file(const std::string& name) {
  const unsigned flags = MFD_CLOEXEC | MFD_ALLOW_SEALING;
  Fd file{::memfd_create(name.c_str(), flags | kMayExecute)};
  if (!file && errno == EINVAL) file = Fd{::memfd_create(name.c_str(), flags)};
  return file;
}

}  // namespace

Result<Fd> sealed_copy(const std::string& path) {
  const Fd from{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (!from) return errno_problem(path, "name a file that can be read");
  return sealed_copy(from, path);
}

Result<Fd> sealed_copy(const Fd& from, const std::string& path) {
  if (!from) return error_problem(path, EMFILE);
  struct stat status {};
  if (::fstat(from.get(), &status) != 0) return errno_problem(path, "name a file that can be read");
  if (!S_ISREG(status.st_mode)) return fail(path + " is not a file", "name a file");
  Fd copy = memory_file(path.substr(path.find_last_of('/') + 1));
  if (!copy && errno == EACCES) {
    return errno_problem("the kernel allows no executable copy of " + path +
                             " in memory, because of its setting vm.memfd_noexec",
                         "run sysctl -w vm.memfd_noexec=1");
  }
  if (!copy) return errno_problem("memfd_create for a copy of " + path, "free memory or file descriptors");
  constexpr std::size_t kAtOnce = std::size_t{1} << 30;
  off_t at = 0;  // the position of `from` itself stays, because other descriptors may share it
  ssize_t copied = 0;
  while ((copied = ::sendfile(copy.get(), from.get(), &at, kAtOnce)) > 0) {
  }
  if (copied < 0) return errno_problem("copying " + path, "free memory");
  if (::fcntl(copy.get(), F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_GROW | F_SEAL_SHRINK | F_SEAL_SEAL) != 0)
    return errno_problem("sealing a copy of " + path);
  return copy;
}

std::string path_of(const Fd& file) {
  // In a container, /proc may show other process ids than getpid().
  std::array<char, 32> self{};
  const ssize_t length = ::readlink("/proc/self", self.data(), self.size() - 1);
  return std::string{"/proc/"} + (length > 0 ? self.data() : "self") + "/fd/" + std::to_string(file.get());
}

}  // namespace takt::os
