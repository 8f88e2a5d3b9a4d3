// Memory that several processes share. The memory has no name in the file system: a process gets it through
// its descriptor. It is freed when the last process that holds it has ended, even if that process crashed.
#pragma once

#include <cstddef>
#include <string>

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

class SharedMemory {
 public:
  SharedMemory() = default;
  SharedMemory(SharedMemory&& other) noexcept;
  SharedMemory& operator=(SharedMemory&& other) noexcept;
  SharedMemory(const SharedMemory&) = delete;
  SharedMemory& operator=(const SharedMemory&) = delete;
  ~SharedMemory();

  /// Creates zeroed memory of fixed size. `name` is only for people (/proc/PID/maps). New programs do not
  /// inherit the descriptor unless it is passed to them.
  static Result<SharedMemory> create(const std::string& name, std::size_t size);
  /// Maps the memory that another process created; takes the descriptor.
  static Result<SharedMemory> attach(Fd fd);

  [[nodiscard]] std::byte* data() const noexcept { return data_; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace takt::os
