// The thread that calls hooks, and that gets and sets properties. A hook is foreign code and may never
// return. Its module is then lost, but the hooks of all other modules must still be called. So the thread can
// be given up together with the module that it is stuck in; a new thread serves the requests that wait.
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
  /// `call` carries out a request and returns the text of its answer. `done` then receives it on the same
  /// thread.
  using Call = std::function<Result<std::string>(const Request&)>;
  using Done = std::function<void(const Request&, const Result<std::string>&)>;

  HookCaller(channel::Activity& activity, std::vector<int> cpus, Call call, Done done);
  /// Ends the thread if it is not stuck.
  ~HookCaller();

  void enqueue(const Request& request);
  /// Leaves the thread in a hook of this module; a late return is ignored. A new thread serves the next
  /// request. Returns false if the hook has returned after all.
  bool give_up(std::uint32_t module);

 private:
  struct Shared;
  void start_thread();

  std::vector<int> cpus_;
  std::shared_ptr<Shared> shared_;  // a thread that was given up keeps it alive
  os::Thread thread_;
};

}  // namespace takt::host
