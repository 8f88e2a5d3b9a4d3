// Reads the messages that the kernel logs (/dev/kmsg) while the program runs.
#pragma once

#include <optional>
#include <string>

#include <takt/os/fd.hpp>

namespace takt::os {

/// Returns new log messages of the kernel, one by one.
class KernelNews {
 public:
  /// Skips all messages that the kernel has already logged. If this user may not read the log, next() never
  /// returns a message.
  KernelNews();

  /// Returns the next message; none if the kernel has logged no new one. Does not wait.
  std::optional<std::string> next();

 private:
  Fd fd_;
};

/// Returns the text of a record of /dev/kmsg: TEXT in "6,1234,5678,-;TEXT\n KEY=VALUE".
std::string kernel_text(const std::string& record);

}  // namespace takt::os
