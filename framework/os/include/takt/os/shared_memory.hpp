// Memory that several processes see. It has no name in the file system: whoever holds the descriptor has it,
// and it is gone when the last process that had it is gone, however that ended.
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

  /// Zeroed, of fixed size. `name` is for humans (/proc/PID/maps). The descriptor is not inherited by new
  /// programs unless handed to them.
  static Result<SharedMemory> create(const std::string& name, std::size_t size);
  /// Maps what another process created; takes the descriptor.
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
