// Tells libtakt_check when a thread enters or leaves the code of a module. That library records the real-time
// violations that modules commit. It is present only if the process was started with it preloaded (LD_PRELOAD).
#pragma once

#include <cstdint>

#include <takt/channel/activity.hpp>
#include <takt/core/result.hpp>

namespace takt::channel {

class CheckReporter {
 public:
  /// Constructs a reporter that is not connected to the library; the reporter converts to false.
  CheckReporter() = default;
  /// Returns the reporter of this process, which converts to false if the library is not loaded. Fails if the
  /// node requested the check of this process, but the library was not loaded.
  static Result<CheckReporter> find();

  explicit operator bool() const noexcept { return enter_ != nullptr; }
  /// From now on, attributes the violations of the calling thread to `module`. Returns the former state of
  /// the thread, which leave() needs. Call this only if `operator bool` returns true. A real-time thread may
  /// call it, but the first call of a thread must not be in real time.
  std::uint64_t enter(std::uint32_t module, Doing hook) const noexcept {
    return enter_(module, static_cast<std::uint32_t>(hook));
  }
  /// Sets the state of the calling thread back to `before`, which enter() returned. Call leave() only if
  /// `operator bool` returns true. A real-time thread may call it.
  void leave(std::uint64_t before) const noexcept { leave_(before); }

 private:
  std::uint64_t (*enter_)(std::uint32_t module, std::uint32_t hook) = nullptr;
  void (*leave_)(std::uint64_t before) = nullptr;
};

}  // namespace takt::channel
