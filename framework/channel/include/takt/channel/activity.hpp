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

/// What one thread is doing. The thread writes it into shared memory, and the supervisor reads it. All zero
/// means "nothing".
struct Activity {
  std::atomic<std::uint32_t> module;  ///< index of the module, plus 1; 0: no module
  std::atomic<Doing> doing;
  std::atomic<std::int64_t> since_ns;  ///< monotonic clock
  std::atomic<std::int32_t> thread;

  /// Records that this thread enters a hook of module `index`. Writes `since_ns` first, so that a reader
  /// never sees a new module with an old time. A real-time thread may call it.
  void begin(std::uint32_t index, Doing what, std::int64_t now_ns) noexcept {
    since_ns.store(now_ns, std::memory_order_relaxed);
    doing.store(what, std::memory_order_relaxed);
    module.store(index + 1, std::memory_order_release);  // SYNC: activity
  }
  /// Does the same as begin(), for a thread that checks afterwards whether the module is still in the tables.
  /// The stronger store ensures that the node sees this activity when it removes the module, or that this
  /// thread sees the removal. Rows do not need it for each module, because they have such a store for each
  /// row. SYNC: in tables
  void announce(std::uint32_t index, Doing what, std::int64_t now_ns) noexcept {
    begin(index, what, now_ns);
    module.store(index + 1, std::memory_order_seq_cst);
  }
  void end() noexcept { module.store(0, std::memory_order_release); }
};

}  // namespace takt::channel
