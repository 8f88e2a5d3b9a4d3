// Wakes a thread that waits for descriptors.
#pragma once

#include <takt/core/result.hpp>
#include <takt/os/fd.hpp>

namespace takt::os {

class Notice {
 public:
  static Result<Notice> create();

  /// Makes fd() readable until the next take(). Any thread; never waits.
  void give() const noexcept;
  /// Whether it was given since the last take().
  bool take() const noexcept;
  [[nodiscard]] const Fd& fd() const noexcept { return fd_; }

 private:
  Fd fd_;
};

}  // namespace takt::os
