// The thread that calls the handlers of a module's services. Each module with handlers has its own thread,
// so a handler that waits delays only its own module. A handler is foreign code and may never return. Then
// the node gives up the thread together with the module, as with HookCaller.
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
    std::uint32_t index;  ///< the module's index
    std::string name;
    std::vector<int> cpus;
    channel::Activity& activity;   ///< shows when the thread is in a handler
    channel::WakeWord& wake_word;  ///< rung when a request arrives
  };
  /// `serve` answers one request, if there is one. The new thread calls both functions.
  ServiceThread(const Options& options, std::function<bool()> has_request, std::function<bool()> serve);
  /// Ends the thread unless it is stuck in a handler.
  ~ServiceThread();
  ServiceThread(const ServiceThread&) = delete;
  ServiceThread& operator=(const ServiceThread&) = delete;

  /// Waits until no handler is being called; none is called while the lock is held.
  [[nodiscard]] std::unique_lock<std::mutex> exclude();
  /// Gives up the thread if it is in a handler. Returns false if it is in none.
  bool give_up();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  // a thread that was given up keeps it alive
  os::Thread thread_;
};

}  // namespace takt::host
