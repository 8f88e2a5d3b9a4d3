// Edges of a flag. For real-time threads.
#pragma once

namespace edge {

/// R_TRIG and F_TRIG of IEC 61131-3, and both.
struct EdgeDetector {
  bool rising = true;
  bool falling = false;

  /// Whether this value ends an edge after the last one.
  bool step(bool value) noexcept {
    const bool edge = known_ && value != last_ && (value ? rising : falling);
    known_ = true;
    last_ = value;
    return edge;
  }
  /// What the flag is taken to have been before the next value.
  void assume(bool value) noexcept {
    known_ = true;
    last_ = value;
  }
  /// The next value is the first: no edge.
  void forget() noexcept { known_ = false; }

 private:
  bool known_ = false;
  bool last_ = false;
};

}  // namespace edge
