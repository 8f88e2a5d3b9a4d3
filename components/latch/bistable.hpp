// The bistable function blocks of IEC 61131-3. For real-time threads.
#pragma once

namespace latch {

/// SR: set wins over reset. RS: reset wins over set.
class Bistable {
 public:
  bool step(bool set, bool reset, bool set_wins) noexcept {
    q_ = set_wins ? set || (q_ && !reset) : !reset && (q_ || set);
    return q_;
  }
  void reset() noexcept { q_ = false; }

 private:
  bool q_ = false;
};

}  // namespace latch
