// Memory that several processes share. It has no name in the file system: a process gets access to it through
// its descriptor. The kernel frees the memory when the last process that holds it has ended, even after a
// crash.
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

  /// Creates memory of fixed size that contains zeros. `name` is only for people, who see it in
  /// /proc/PID/maps. Programs that this process starts do not inherit the descriptor unless it is passed to
  /// them.
  static Result<SharedMemory> create(const std::string& name, std::size_t size);
  /// Maps memory that another process created. Takes over the descriptor.
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
