// Tells libtakt_check, where it was loaded in front of the C library, that a thread is in a module.
#pragma once

#include <cstdint>

#include <takt/channel/activity.hpp>
#include <takt/core/result.hpp>

namespace takt::channel {

class ModuleWatch {
 public:
  /// Nobody watches.
  ModuleWatch() = default;
  /// Of this program. Fails when it was to be checked and the library was not loaded.
  static Result<ModuleWatch> find();

  explicit operator bool() const noexcept { return enter_ != nullptr; }
  /// Only where somebody watches. From now on it counts what the calling thread does, as that of `module`.
  /// Returns what it was before. Real-time, but for the first time on a thread.
  std::uint64_t enter(std::uint32_t module, Doing hook) const noexcept {
    return enter_(module, static_cast<std::uint32_t>(hook));
  }
  /// It is again as it was.
  void leave(std::uint64_t before) const noexcept { leave_(before); }

 private:
  std::uint64_t (*enter_)(std::uint32_t module, std::uint32_t hook) = nullptr;
  void (*leave_)(std::uint64_t before) = nullptr;
};

}  // namespace takt::channel
