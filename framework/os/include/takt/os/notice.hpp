// Wakes a thread that waits for descriptors.
#pragma once

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// A flag that makes a descriptor readable.
class Notice {
 public:
  static Result<Notice> create();

  /// Makes fd() readable until the next take(). Any thread may call it. Never waits.
  void give() const noexcept;
  /// Whether give() was called since the last take().
  bool take() const noexcept;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
};

}  // namespace takt::os
