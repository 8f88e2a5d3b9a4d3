// Reports to libtakt_check when a thread enters and leaves the code of a module. The library is present only
// if it was preloaded before the C library.
#pragma once

#include <cstdint>

#include <takt/channel/activity.hpp>
#include <takt/core/result.hpp>

namespace takt::channel {

class ModuleWatch {
 public:
  /// Constructs a watch that is not connected to the library; it converts to false.
  ModuleWatch() = default;
  /// Returns the watch of this process; it converts to false if there is no library. Fails if the process
  /// should be checked but the library was not loaded.
  static Result<ModuleWatch> find();

  explicit operator bool() const noexcept { return enter_ != nullptr; }
  /// From now on, violations of the calling thread count for `module`. Returns the former state of the
  /// thread, for leave(). Call this only if `operator bool` returns true. A real-time thread may call it,
  /// unless it is the thread's first call.
  std::uint64_t enter(std::uint32_t module, Doing hook) const noexcept {
    return enter_(module, static_cast<std::uint32_t>(hook));
  }
  /// Restores the state that enter() returned. Call this only if `operator bool` returns true. A real-time
  /// thread may call it.
  void leave(std::uint64_t before) const noexcept { leave_(before); }

 private:
  std::uint64_t (*enter_)(std::uint32_t module, std::uint32_t hook) = nullptr;
  void (*leave_)(std::uint64_t before) = nullptr;
};

}  // namespace takt::channel
