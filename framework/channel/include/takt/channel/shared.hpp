// An array of objects in memory that a device's processes share.
#pragma once

#include <cstddef>
#include <new>
#include <string>

#include <takt/core/result.hpp>
#include <takt/os/shared_memory.hpp>

namespace takt::channel {

/// Holds objects of a type that is valid when all its bytes are 0. The memory lives as long as this object,
/// across restarts of the processes that use it.
template <class T>
class Shared {
 public:
  Shared() = default;
  /// `name` only identifies the memory in /proc/PID/maps, for people.
  static Result<Shared> create(const std::string& name, std::size_t count = 1) {
    auto memory = os::SharedMemory::create(name, count * sizeof(T));
    if (!memory) return memory.problems();
    Shared shared;
    shared.memory_ = std::move(*memory);
    return shared;
  }

  [[nodiscard]] explicit operator bool() const noexcept { return memory_.data() != nullptr; }
  /// Requires that this object has memory and that `index` is below the count.
  [[nodiscard]] T& operator[](std::size_t index) const noexcept { return data()[index]; }
  /// Returns null if this object has no memory.
  [[nodiscard]] T* data() const noexcept {
    std::byte* const bytes = memory_.data();
    return bytes == nullptr ? nullptr : std::launder(reinterpret_cast<T*>(bytes));
  }
  [[nodiscard]] const os::SharedMemory& memory() const noexcept { return memory_; }

 private:
  os::SharedMemory memory_;
};

}  // namespace takt::channel
