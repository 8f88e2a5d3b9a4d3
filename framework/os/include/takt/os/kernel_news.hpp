// What the kernel says while we run (/dev/kmsg).
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

/// The text of a record of /dev/kmsg, "6,1234,5678,-;TEXT\n KEY=VALUE": TEXT.
std::string kernel_text(const std::string& record);

}  // namespace takt::os
