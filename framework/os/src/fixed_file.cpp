#include <takt/os/fixed_file.hpp>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <filesystem>

#include "error.hpp"

namespace takt::os {

Result<FixedFile> FixedFile::open(const std::string& path) {
  const std::string folder = std::filesystem::path{path}.parent_path().string();
  std::error_code error;
  if (!folder.empty()) std::filesystem::create_directories(folder, error);
  if (error) return error_problem(folder, error.value(), advice_to_write(error.value()));
  FixedFile file;
  file.path_ = path;
  file.fd_ = Fd{::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0644)};
  if (!file.fd_) return errno_problem(path, advice_to_write(errno));
  struct stat status {};
  if (::fstat(file.fd_.get(), &status) != 0 || !S_ISREG(status.st_mode))
    return Problem{path, "is not a regular file", "name another folder"};
  if (::flock(file.fd_.get(), LOCK_EX | LOCK_NB) != 0)
    return Problem{path, "is in use by another process", "end that process, or name another folder"};
  return file;
}

Result<void> FixedFile::reserve(std::size_t bytes) {
  struct stat before {};
  if (::fstat(fd_.get(), &before) != 0) return errno_problem(path_);
  const int error = ::posix_fallocate(fd_.get(), 0, static_cast<off_t>(bytes));
  if (error == 0) return {};
  // Free the space that posix_fallocate() had allocated before it failed.
  if (::ftruncate(fd_.get(), before.st_size) != 0) return errno_problem(path_);
  return error_problem(path_, error, advice_to_write(error));
}

Result<std::string> FixedFile::read(std::size_t most) const {
  std::string content;
  std::array<char, 65536> part{};
  while (content.size() <= most) {
    const ssize_t n = ::pread(fd_.get(), part.data(), part.size(), static_cast<off_t>(content.size()));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno_problem(path_);
    if (n == 0) return content;
    content.append(part.data(), static_cast<std::size_t>(n));
  }
  return Problem{path_, "has more than " + std::to_string(most) + " bytes", ""};
}

Result<void> FixedFile::write(std::size_t at, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::pwrite(fd_.get(), bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno_problem(path_);
    at += static_cast<std::size_t>(n);
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return {};
}

void FixedFile::sync() const noexcept { static_cast<void>(::fdatasync(fd_.get())); }

Result<void> FixedFile::rename(const std::string& path) {
  if (::rename(path_.c_str(), path.c_str()) != 0) return errno_problem(path_);
  path_ = path;
  return {};
}

}  // namespace takt::os
