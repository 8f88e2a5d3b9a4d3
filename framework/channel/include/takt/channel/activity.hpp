// What a thread of the host is doing right now. If the thread crashes or hangs, the node finds here which
// module caused it.
#pragma once

#include <atomic>
#include <cstdint>

namespace takt::channel {

enum class Doing : std::uint32_t {
  nothing,
  run,
  condition,
  initialize,
  start,
  error,
  recover,
  destruct,
  load,
  serve
};
/// "run()", "initialize()", ...
const char* to_text(Doing doing) noexcept;

/// Written by one thread and read by the supervisor, in shared memory. All zero means "nothing".
struct Activity {
  std::atomic<std::uint32_t> module;  ///< index of the module, + 1; 0: none
  std::atomic<Doing> doing;
  std::atomic<std::int64_t> since_ns;  ///< monotonic clock
  std::atomic<std::int32_t> thread;

  /// Real-time. Writes `since_ns` first, so that a reader never sees a new module with an old time.
  void begin(std::uint32_t index, Doing what, std::int64_t now_ns) noexcept {
    since_ns.store(now_ns, std::memory_order_relaxed);
    doing.store(what, std::memory_order_relaxed);
    module.store(index + 1, std::memory_order_release);  // SYNC: activity
  }
  /// Like begin(), for a thread that checks afterwards whether the module is in the tables. Either the node,
  /// when it takes the module out, sees this activity, or this thread sees that the module is out. Rows do
  /// not need this fence for each module, because they have one per row. SYNC: in tables
  void announce(std::uint32_t index, Doing what, std::int64_t now_ns) noexcept {
    begin(index, what, now_ns);
    module.store(index + 1, std::memory_order_seq_cst);
  }
  void end() noexcept { module.store(0, std::memory_order_release); }
};

}  // namespace takt::channel
