// The thread that calls the handlers of a module's services. Each module with handlers has its own thread,
// so a handler that waits delays only its own module. A handler is foreign code and may never return; the
// thread is then given up together with the module, as HookCaller's is.
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
    std::uint32_t index;  ///< of the module
    std::string name;
    std::vector<int> cpus;
    channel::Activity& activity;   ///< shows when the thread is in a handler
    channel::WakeWord& wake_word;  ///< rung when a request arrives
  };
  /// `serve` answers one request, if there is one. The thread calls both functions.
  ServiceThread(const Options& options, std::function<bool()> has_request, std::function<bool()> serve);
  /// Ends the thread if it is not stuck.
  ~ServiceThread();
  ServiceThread(const ServiceThread&) = delete;
  ServiceThread& operator=(const ServiceThread&) = delete;

  /// Waits until no handler is being called; none is called while the lock is held.
  [[nodiscard]] std::unique_lock<std::mutex> exclude();
  /// Leaves the thread in its current handler. Returns false if it is in none.
  bool give_up();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  // a thread that was given up keeps it alive
  os::Thread thread_;
};

}  // namespace takt::host
