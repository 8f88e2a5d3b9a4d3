// Reads the messages that the kernel logs while the program runs (/dev/kmsg).
#pragma once

#include <optional>
#include <string>

#include <takt/os/fd.hpp>

namespace takt::os {

class KernelNews {
 public:
  /// From now on. Where this user may not read it, there are never any news.
  KernelNews();

  /// The next line that was said; none when there is none yet. Does not wait.
  std::optional<std::string> next();

 private:
  Fd fd_;
};

/// The TEXT of a record of /dev/kmsg, "6,1234,5678,-;TEXT\n KEY=VALUE".
std::string kernel_text(const std::string& record);

}  // namespace takt::os
