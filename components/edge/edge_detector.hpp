// Detects edges of a flag. For real-time threads.
#pragma once

namespace edge {

/// Detects edges as R_TRIG or F_TRIG of IEC 61131-3 does, or both kinds of edges.
struct EdgeDetector {
  bool rising = true;
  bool falling = false;

  /// Whether there is an edge from the last value to this one.
  bool step(bool value) noexcept {
    const bool edge = known_ && value != last_ && (value ? rising : falling);
    known_ = true;
    last_ = value;
    return edge;
  }
  /// Sets the value that counts as the one before the next value.
  void assume(bool value) noexcept {
    known_ = true;
    last_ = value;
  }
  /// The next value counts as the first one, which is not an edge.
  void forget() noexcept { known_ = false; }

 private:
  bool known_ = false;
  bool last_ = false;
};

}  // namespace edge
