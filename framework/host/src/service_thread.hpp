// The thread that calls the handlers of a module's services. One for each module that has some: a handler may
// wait for a while, and that is to cost nobody but its own module. It is foreign code and may never return;
// then the thread is given up with the module, as HookCaller's is.
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
    channel::Activity& activity;   ///< says when it is in a handler
    channel::WakeWord& wake_word;  ///< rung when a request has come
  };
  /// `serve` answers one request, if there is one; both are called on the thread.
  ServiceThread(const Options& options, std::function<bool()> has_request, std::function<bool()> serve);
  /// Ends the thread if it is not stuck.
  ~ServiceThread();
  ServiceThread(const ServiceThread&) = delete;
  ServiceThread& operator=(const ServiceThread&) = delete;

  /// Waits for a handler to return; none is called as long as this is held.
  [[nodiscard]] std::unique_lock<std::mutex> exclude();
  /// Leaves the thread in the handler that it is in. False when it is in none.
  bool give_up();

 private:
  struct Shared;
  std::shared_ptr<Shared> shared_;  // outlives us in a thread that was given up
  os::Thread thread_;
};

}  // namespace takt::host
