// What a thread of the host is doing right now. If the thread crashes or hangs, the node reads here which
// module caused this.
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
  serve,
  thread  ///< in a thread that the module has started itself; no Activity has this value
};
/// Returns the activity as text: "run()", "initialize()", ...
const char* to_text(Doing doing) noexcept;

/// What one thread is doing. The thread writes the record into shared memory, and the supervisor reads it. If
/// all bytes are zero, the thread is in no hook.
struct Activity {
  std::atomic<std::uint32_t> module;  ///< index of the module, plus 1; 0: no module
  std::atomic<Doing> doing;
  std::atomic<std::int64_t> since_ns;  ///< when the activity began, in ns of the monotonic clock
  std::atomic<std::int32_t> thread;    ///< the thread that carries out the activity, as in /proc

  /// Records that this thread enters a hook of module `index`. Writes `since_ns` first, so that a reader
  /// never sees a new module with an old time. A real-time thread may call it.
  void begin(std::uint32_t index, Doing what, std::int64_t now_ns) noexcept {
    since_ns.store(now_ns, std::memory_order_release);  // after end() of the activity before
    doing.store(what, std::memory_order_release);
    module.store(index + 1, std::memory_order_release);  // after the stores above
  }
  /// Does the same as begin(), for a thread that checks afterwards whether the module is still in the tables.
  /// The stronger store ensures one of two things: the node sees this activity when it removes the module, or
  /// this thread sees the removal (see Removal). In a row, begin() is enough for each module, because the
  /// executor makes such a store at the start of the row.
  void announce(std::uint32_t index, Doing what, std::int64_t now_ns) noexcept {
    begin(index, what, now_ns);
    module.store(index + 1, std::memory_order_seq_cst);
  }
  void end() noexcept { module.store(0, std::memory_order_release); }
};

}  // namespace takt::channel
