// Memory that several processes share. It has no name in the file system: a process gets access through a
// file descriptor. The kernel frees the memory when no process holds it any more, even after a crash.
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

  /// Creates memory of fixed size that contains zeros. `name` is for people, who see it in /proc/PID/maps.
  /// Child processes inherit the file descriptor only if it is in SpawnOptions::inherit.
  static Result<SharedMemory> create(const std::string& name, std::size_t size);
  /// Maps memory that another process created. Takes over the file descriptor.
  static Result<SharedMemory> attach(Fd fd);

  /// Makes the first `size` bytes read-only for this process. A page that is only partly in this range stays
  /// writable.
  Result<void> make_read_only(std::size_t size);

  [[nodiscard]] std::byte* data() const noexcept { return data_; }
  [[nodiscard]] std::size_t size() const noexcept { return size_; }
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
  std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

}  // namespace takt::os
