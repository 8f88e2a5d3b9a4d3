// A file of fixed size that is written in place, piece by piece. All its space is allocated in advance, so
// that writing cannot fail later because the disk is full.
//
// System calls write the file, not a mapping. So a disk error or a truncated file makes a call fail instead
// of raising SIGBUS.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

class FixedFile {
 public:
  /// Opens the file, or creates an empty file and its folder. Locks the file. Fails while another process has
  /// opened the file with this function.
  static Result<FixedFile> open(const std::string& path);
  /// Allocates space for this many bytes; new bytes are zero. Fails if the disk is full; then the size does
  /// not change.
  Result<void> reserve(std::size_t bytes);
  /// The whole content. Fails if it has more than `most` bytes.
  [[nodiscard]] Result<std::string> read(std::size_t most) const;
  /// Writes in place. A process that is killed during the call may have written only the first part. The
  /// bytes survive a loss of power after sync() has returned.
  Result<void> write(std::size_t at, std::string_view bytes);
  /// Waits until the disk has stored everything.
  void sync() const noexcept;
  /// Renames the file; replaces an existing file of that name.
  Result<void> rename(const std::string& path);

 private:
  std::string path_;
  Fd fd_;
};

}  // namespace takt::os
