// A file of fixed size whose parts are written in place. All its space is allocated in advance, so that a
// later write cannot fail because the disk is full.
//
// The file is written with system calls and not through a memory mapping. So a disk error or a truncated file
// makes a call fail and does not raise SIGBUS.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

class FixedFile {
 public:
  /// Opens and locks the file. Creates the file and its folder if they do not exist. Fails while another
  /// process has the file open through this function.
  static Result<FixedFile> open(const std::string& path);
  /// Allocates space for a file of this many bytes; new bytes are zero. Fails if the disk is full; then the
  /// size of the file does not change.
  Result<void> reserve(std::size_t bytes);
  /// Reads the whole file. Fails if it has more than `most` bytes.
  [[nodiscard]] Result<std::string> read(std::size_t most) const;
  /// Writes the bytes at this position. If the process is killed during the call, only the first part of them
  /// may be written. After sync() has returned, the bytes survive a loss of power.
  Result<void> write(std::size_t at, std::string_view bytes);
  /// Waits until everything that was written is stored on the disk.
  void sync() const noexcept;
  /// Renames the file. Replaces an existing file with the new name.
  Result<void> rename(const std::string& path);

 private:
  std::string path_;
  Fd fd_;
};

}  // namespace takt::os
