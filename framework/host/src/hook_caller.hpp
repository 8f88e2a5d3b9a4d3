// The thread that calls hooks, and that gets and sets properties. A hook is foreign code and may never
// return. Then the node gives up the hook's module together with the thread, and a new thread serves the
// requests of the other modules.
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
  /// `call` carries out a request and returns the text of the answer. `done` then receives this result on the
  /// same thread.
  using Call = std::function<Result<std::string>(const Request&)>;
  using Done = std::function<void(const Request&, const Result<std::string>&)>;

  HookCaller(channel::Activity& activity, std::vector<int> cpus, Call call, Done done);
  /// Ends the thread unless it is stuck in a hook.
  ~HookCaller();

  void enqueue(const Request& request);
  /// Gives up the thread if it is in a hook of this module. If the hook returns later, its result is ignored.
  /// A new thread serves the next requests. Returns false if the thread is in no hook of this module.
  bool give_up(std::uint32_t module);

 private:
  struct Shared;
  void start_thread();

  std::vector<int> cpus_;
  std::shared_ptr<Shared> shared_;  // also kept alive by a thread that was given up
  os::Thread thread_;
};

}  // namespace takt::host
