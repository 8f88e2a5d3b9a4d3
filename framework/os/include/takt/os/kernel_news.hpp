// Reads the messages that the kernel logs while the program runs (/dev/kmsg).
#pragma once

#include <optional>
#include <string>

#include <takt/os/fd.hpp>

namespace takt::os {

/// The new messages of the kernel.
class KernelNews {
 public:
  /// Starts with the next message. If this user may not read the log, next() returns no messages.
  KernelNews();

  /// The next message; none if there is no new one. Does not wait.
  std::optional<std::string> next();

 private:
  Fd fd_;
};

/// The TEXT of a record of /dev/kmsg, "6,1234,5678,-;TEXT\n KEY=VALUE".
std::string kernel_text(const std::string& record);

}  // namespace takt::os
