// A file of fixed size that is written in place, a piece at a time: all its room is taken when it is made, so
// that a disk that is full later cannot keep anything from being written.
//
// Pieces are written by system calls and not through a mapping of the file: an error of the disk, or somebody
// who cuts the file short, is then a failed call and no SIGBUS.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

class FixedFile {
 public:
  /// Opens it, or makes an empty one and its folder. It is this process's alone: fails while another one has
  /// it open by this function.
  static Result<FixedFile> open(const std::string& path);
  /// Makes room for so many bytes; what is new is zero. Fails where the disk is full; it has then the size
  /// that it had.
  Result<void> reserve(std::size_t bytes);
  /// All that is in it. Fails when that is more than `most` bytes.
  [[nodiscard]] Result<std::string> read(std::size_t most) const;
  /// What is killed in the middle has written the first part of it. After a loss of power it is there once
  /// sync() has returned.
  Result<void> write(std::size_t at, std::string_view bytes);
  /// Waits for the disk.
  void sync() const noexcept;
  /// The file gets another name; one of that name is lost.
  Result<void> rename(const std::string& path);

 private:
  std::string path_;
  Fd fd_;
};

}  // namespace takt::os
