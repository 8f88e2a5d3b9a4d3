// What a thread of the host is doing right now, for whoever must name the culprit when it crashes or never
// comes back.
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

/// Written by one thread, read by the supervisor. Lies in shared memory; all zero is "nothing".
struct Activity {
  std::atomic<std::uint32_t> module;  ///< its index + 1; 0: none
  std::atomic<Doing> doing;
  std::atomic<std::int64_t> since_ns;  ///< monotonic
  std::atomic<std::int32_t> thread;

  /// Real-time. `since` is written first, so that a reader never sees a new module with an old time.
  void begin(std::uint32_t index, Doing what, std::int64_t now_ns) noexcept {
    since_ns.store(now_ns, std::memory_order_relaxed);
    doing.store(what, std::memory_order_relaxed);
    module.store(index + 1, std::memory_order_release);  // SYNC: activity
  }
  /// As begin(), for a thread that asks afterwards whether the module is in the tables: who takes it out
  /// either sees this activity, or is seen. A row needs no such fence a module; it has one a row. SYNC: in
  /// tables
  void announce(std::uint32_t index, Doing what, std::int64_t now_ns) noexcept {
    begin(index, what, now_ns);
    module.store(index + 1, std::memory_order_seq_cst);
  }
  void end() noexcept { module.store(0, std::memory_order_release); }
};

}  // namespace takt::channel
