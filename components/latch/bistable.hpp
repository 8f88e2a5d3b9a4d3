// The mathematics of the component latch: the bistable function blocks of IEC 61131-3. Real-time threads may
// use everything here.
#pragma once

namespace latch {

/// The blocks SR, in which set wins over reset, and RS, in which reset wins over set.
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
