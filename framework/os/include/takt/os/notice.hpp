// Wakes a thread that waits until file descriptors are readable.
#pragma once

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

/// A flag with a file descriptor, which is readable while the flag is set.
class Notice {
 public:
  static Result<Notice> create();

  /// Sets the flag. fd() is readable until the next take(). Any thread may call this. Never waits.
  void give() const noexcept;
  /// Clears the flag. Returns true if give() was called since the last take().
  bool take() const noexcept;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
};

}  // namespace takt::os
