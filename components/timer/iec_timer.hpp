// The mathematics of the component timer: the timers of IEC 61131-3. Real-time threads may use everything
// here.
#pragma once

#include <algorithm>
#include <cstdint>

namespace timer {

enum class Kind {
  on_delay,   ///< TON: Q becomes true when the input has been true for the preset time
  off_delay,  ///< TOF: Q becomes false when the input has been false for the preset time
  pulse,      ///< TP: a rising edge makes Q true for the preset time; edges during the pulse have no effect
};

/// A timer. Its time begins at the step that detects the edge of the input.
class IecTimer {
 public:
  /// Makes one step and returns Q. `passed_ns`: time since the last step. `preset_ns`: the preset time PT, at
  /// least 0.
  bool step(Kind kind, bool in, std::int64_t passed_ns, std::int64_t preset_ns) noexcept {
    if (kind == Kind::pulse) {
      if (running_) {
        elapsed_ns_ += passed_ns;
      } else if (in && !last_) {
        running_ = true;
        elapsed_ns_ = 0;
      }
      if (running_ && elapsed_ns_ >= preset_ns) {
        running_ = false;
        done_ = true;
      }
      if (done_) elapsed_ns_ = in ? preset_ns : 0;
      done_ = done_ && in;
      last_ = in;
      return running_;
    }
    const bool counts = kind == Kind::on_delay ? in : !in;
    const bool begins = counts && !running_ && !done_ && (kind == Kind::on_delay || last_);
    if (!counts) {
      running_ = done_ = false;
      elapsed_ns_ = 0;
    } else if (begins) {
      running_ = true;
      elapsed_ns_ = 0;
    } else if (running_) {
      elapsed_ns_ += passed_ns;
    }
    if (running_ && elapsed_ns_ >= preset_ns) {
      running_ = false;
      done_ = true;
    }
    if (done_) elapsed_ns_ = preset_ns;
    last_ = in;
    return kind == Kind::on_delay ? done_ : in || running_;
  }
  /// Returns ET: the elapsed time, at most PT.
  [[nodiscard]] std::int64_t elapsed_ns() const noexcept { return elapsed_ns_; }
  void reset() noexcept { *this = {}; }

 private:
  bool last_ = false;
  bool running_ = false;
  bool done_ = false;  // true: the time has elapsed, and the input has not changed since then
  std::int64_t elapsed_ns_ = 0;
};

}  // namespace timer
