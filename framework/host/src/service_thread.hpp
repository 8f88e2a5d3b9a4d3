// The thread that calls the handlers of a module's services. Each module with handlers has its own thread, so
// a handler that waits delays only its own module. A handler is foreign code and may never return. Then the
// node gives up the module together with this thread.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <takt/channel/activity.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/os/real_time.hpp>

namespace takt::host {

class ServiceThread {
 public:
  struct Options {
    std::uint32_t index;  ///< the module's index on its device
    std::string name;
    std::vector<int> cpus;
    channel::Activity& activity;   ///< shows when the thread is in a handler
    channel::WakeWord& wake_word;  ///< another thread rings this word when a request arrives
  };
  /// `has_request` returns true if a request waits; `serve` answers one request. The new thread calls both.
  ServiceThread(const Options& options, std::function<bool()> has_request, std::function<bool()> serve);
  /// Waits until the thread has ended, unless the thread was given up.
  ~ServiceThread();
  ServiceThread(const ServiceThread&) = delete;
  ServiceThread& operator=(const ServiceThread&) = delete;

  /// Waits until no handler is being called. No handler is called while the returned lock is held.
  [[nodiscard]] std::unique_lock<std::mutex> exclude();
  /// True if the thread is in a handler.
  [[nodiscard]] bool serves() const noexcept;
  /// Gives up a thread that may never end, because a handler or a hook of the module does not return.
  void give_up();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  // also kept alive by a thread that was given up
  os::Thread thread_;
};

}  // namespace takt::host
