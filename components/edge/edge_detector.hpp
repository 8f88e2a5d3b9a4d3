// The mathematics of the component edge. Real-time threads may use everything here.
#pragma once

namespace edge {

/// Detects edges as R_TRIG or F_TRIG of IEC 61131-3 does, or both kinds of edges.
struct EdgeDetector {
  bool rising = true;
  bool falling = false;

  /// Makes one step. Returns true if the change from the last value to `value` is an edge to detect.
  bool step(bool value) noexcept {
    const bool edge = known_ && value != last_ && (value ? rising : falling);
    known_ = true;
    last_ = value;
    return edge;
  }
  /// Sets the last value. The next step compares its value with this one.
  void assume(bool value) noexcept {
    known_ = true;
    last_ = value;
  }
  /// Forgets the last value. The value of the next step is then never an edge.
  void forget() noexcept { known_ = false; }

 private:
  bool known_ = false;
  bool last_ = false;
};

}  // namespace edge
