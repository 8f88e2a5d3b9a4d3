// An array of objects in memory that a device's processes share.
#pragma once

#include <cstddef>
#include <new>
#include <string>

#include <takt/core/result.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::channel {

/// Holds objects of a type that is valid when all its bytes are 0. The memory lives as long as this object,
/// even if the processes that use the memory restart.
template <class T>
class Shared {
 public:
  Shared() = default;
  /// Creates memory for `count` objects. People see `name` in /proc/PID/maps; it has no other use.
  static Result<Shared> create(const std::string& name, std::size_t count = 1) {
    auto memory = os::SharedMemory::create(name, count * sizeof(T));
    if (!memory) return memory.problems();
    Shared shared;
    shared.memory_ = std::move(*memory);
    return shared;
  }

  [[nodiscard]] explicit operator bool() const noexcept { return memory_.data() != nullptr; }
  /// Returns one object of the array. Requires that create() succeeded and that `index` is below its `count`.
  [[nodiscard]] T& operator[](std::size_t index) const noexcept { return data()[index]; }
  /// Returns the first object of the array; null if create() was not called.
  [[nodiscard]] T* data() const noexcept {
    std::byte* const bytes = memory_.data();
    return bytes == nullptr ? nullptr : std::launder(reinterpret_cast<T*>(bytes));
  }
  [[nodiscard]] const os::SharedMemory& memory() const noexcept { return memory_; }

 private:
  os::SharedMemory memory_;
};

}  // namespace takt::channel
