#include <takt/os/shared_memory.hpp>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <utility>

#include "error.hpp"

namespace takt::os {

SharedMemory::SharedMemory(SharedMemory&& other) noexcept
    : fd_(std::move(other.fd_)),
      data_(std::exchange(other.data_, nullptr)),
      size_(std::exchange(other.size_, 0)) {}

SharedMemory& SharedMemory::operator=(SharedMemory&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

SharedMemory::~SharedMemory() {
  if (data_ != nullptr) ::munmap(data_, size_);
}

Result<SharedMemory> SharedMemory::create(const std::string& name, std::size_t size) {
  Fd fd{::memfd_create(name.c_str(), MFD_CLOEXEC | MFD_ALLOW_SEALING)};
  if (!fd) return errno_problem("memfd_create " + name, "free memory or file descriptors");
  if (::ftruncate(fd.get(), static_cast<off_t>(size)) != 0)
    return errno_problem("ftruncate " + name, "free memory");
  // Seal the memory, so that no process can remove pages that another process reads.
  ::fcntl(fd.get(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL);
  return attach(std::move(fd));
}

Result<SharedMemory> SharedMemory::attach(Fd fd) {
  struct stat status {};
  if (::fstat(fd.get(), &status) != 0) return errno_problem("fstat of shared memory");
  SharedMemory memory;
  memory.size_ = static_cast<std::size_t>(status.st_size);
  void* data = ::mmap(nullptr, memory.size_, PROT_READ | PROT_WRITE, MAP_SHARED, fd.get(), 0);
  if (data == MAP_FAILED) return errno_problem("mmap of shared memory", "free memory");
  memory.data_ = static_cast<std::byte*>(data);
  memory.fd_ = std::move(fd);
  return memory;
}

Result<void> SharedMemory::make_read_only(std::size_t size) {
  const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
  if (::mprotect(data_, size / page * page, PROT_READ) != 0)
    return errno_problem("mprotect of shared memory");
  return {};
}

}  // namespace takt::os
