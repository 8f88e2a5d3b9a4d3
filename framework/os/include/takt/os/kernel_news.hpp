// Reads the messages that the kernel logs (/dev/kmsg) while the program runs.
#pragma once

#include <optional>
#include <string>

#include <takt/os/fd.hpp>

namespace takt::os {

/// Returns the kernel's new log messages one by one.
class KernelNews {
 public:
  /// Begins with the next message that the kernel logs. If this user may not read the log, next() never
  /// returns a message.
  KernelNews();

  /// Returns the next message, or none if there is no new one. Does not wait.
  std::optional<std::string> next();

 private:
  Fd fd_;
};

/// Returns the text of a record of /dev/kmsg: TEXT in "6,1234,5678,-;TEXT\n KEY=VALUE".
std::string kernel_text(const std::string& record);

}  // namespace takt::os
