// Prints the node's events on standard error, one per line, for the user at the terminal.
#pragma once

#include <cstddef>
#include <memory>
#include <string_view>

#include <takt/core/time.hpp>
#include <takt/os/real_time.hpp>

namespace takt::node {

/// Prints "14:03:07.250 DEVICE.MODULE: TEXT"; `module` may be empty. Real-time threads must not call this.
void log(std::string_view device, std::string_view module, std::string_view text);

/// From now on, log() prints nothing in this process (`--quiet`). Functions still return their errors to
/// their callers.
void log_nothing();

struct LogQueue;

/// From start() until the object is destroyed, a separate thread prints the lines of log(), so log() never
/// waits for the program or the terminal that reads them. If nothing reads them, lines of up to kMost bytes
/// wait; further lines are dropped, and their number is printed in their place. At most one object exists at
/// a time.
class LogThread {
 public:
  static constexpr std::size_t kMost = 1 << 20;
  /// The longest time that the destructor waits until all lines are printed.
  static constexpr Nanoseconds kLastLines = std::chrono::seconds{1};

  LogThread() = default;
  ~LogThread();
  LogThread(const LogThread&) = delete;
  LogThread& operator=(const LogThread&) = delete;

  /// If the thread cannot be started, log() prints each line itself.
  void start();

 private:
  std::shared_ptr<LogQueue> queue_;  // the thread may outlive this object
  os::Thread thread_;
};

}  // namespace takt::node
