// A thread for work that may take long, such as the creation of readers and writers on DDS. The node's main
// loop must not wait for such work.
#pragma once

#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include <takt/core/result.hpp>
#include <takt/os/real_time.hpp>

namespace takt::node {

class Worker {
 public:
  /// Starts a thread with this name.
  static Result<std::unique_ptr<Worker>> start(const std::string& name);
  /// Waits for the call that is running. Drops the calls that have not begun.
  ~Worker();
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;

  /// Makes the thread call `work`, after all functions that were added before. Never waits for a call. Any
  /// thread may call it.
  void add(std::function<void()> work);
  /// Returns true if the thread has called all functions that were added.
  [[nodiscard]] bool is_idle();

 private:
  Worker() = default;
  void run();

  std::mutex mutex_;  // never held during a call
  std::condition_variable changed_;
  std::deque<std::function<void()>> waiting_;
  bool calling_ = false;
  bool ending_ = false;
  os::Thread thread_;
};

}  // namespace takt::node
