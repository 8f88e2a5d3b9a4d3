// A file of fixed size whose parts are written in place. All its space is allocated in advance, so that a
// later write cannot fail because the disk is full.
//
// The file is written with system calls, not through a memory mapping. So after a disk error, or if the file
// was truncated, a call fails; the process does not get SIGBUS.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

class FixedFile {
 public:
  /// Opens the file, and locks it until this object is destroyed. Creates the file and its folder if they do
  /// not exist. Fails while another process has the file open with this function.
  static Result<FixedFile> open(const std::string& path);
  /// Allocates disk space for a file of this many bytes. New bytes are zero. Fails if the disk is full, and
  /// then leaves the size of the file unchanged.
  Result<void> reserve(std::size_t bytes);
  /// Reads the whole file. Fails if it has more than `most` bytes.
  [[nodiscard]] Result<std::string> read(std::size_t most) const;
  /// Writes `bytes` at position `at`. If the process is killed during the call, the file may contain only the
  /// first part of `bytes`. After sync() has returned, the bytes survive a loss of power.
  Result<void> write(std::size_t at, std::string_view bytes);
  /// Waits until all written bytes are stored on the disk.
  void sync() const noexcept;
  /// Renames the file. A file that already has the new name is replaced.
  Result<void> rename(const std::string& path);

 private:
  std::string path_;
  Fd fd_;
};

}  // namespace takt::os
