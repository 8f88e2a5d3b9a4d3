// The thread that calls hooks, and gets and sets properties, which is for the same thread. A hook is foreign
// code and may never return; then its module is lost, but the hooks of all others must go on being called. So
// the thread can be given up, with the module that it is stuck in, and a new one goes on with what was
// waiting.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include <takt/channel/layout.hpp>
#include <takt/host/protocol.hpp>
#include <takt/os/real_time.hpp>

namespace takt::host {

class HookCaller {
 public:
  /// `call` does what a request wants and returns what is to be said of it; `done` is told, on the same
  /// thread.
  using Call = std::function<Result<std::string>(const Request&)>;
  using Done = std::function<void(const Request&, const Result<std::string>&)>;

  HookCaller(channel::Activity& activity, std::vector<int> cpus, Call call, Done done);
  /// Ends the thread if it is not stuck.
  ~HookCaller();

  void enqueue(const Request& request);
  /// Leaves the thread in a hook of this module; if it ever returns, nobody is told. The next request is
  /// served by a new thread. False when it came back after all.
  bool give_up(std::uint32_t module);

 private:
  struct Shared;
  void start_thread();

  std::vector<int> cpus_;
  std::shared_ptr<Shared> shared_;  // outlives us in a thread that was given up
  os::Thread thread_;
};

}  // namespace takt::host
