// The logic of an emergency stop with two channels. For real-time threads.
#pragma once

#include <cstdint>

namespace emergency_stop {

enum class State : std::uint8_t {
  permitted = 0,    ///< running is permitted
  stopped = 1,      ///< a channel is open, or was and the other has not followed
  wait_reset = 2,   ///< both channels are closed; a reset permits
  discrepancy = 3,  ///< a channel did not follow the other; both have to open first
  no_signal = 4,    ///< a channel was never heard, or not for too long
};

/// Closed (true) channels mean that nobody asks for a stop. After PLCopen Safety: SF_Equivalent for the two
/// channels, SF_EmergencyStop for the rest: with a manual reset, also after the start
/// unless start_reset.
class TwoChannelStop {
 public:
  struct Inputs {
    bool a = false, b = false;  ///< closed
    bool fresh = false;         ///< both were heard lately
    bool reset = false;         ///< the button
    bool reset_fresh = false;   ///< was heard lately
    bool start_reset = false;   ///< the first time needs none
  };

  /// Times in nanoseconds: since the last step; within which one channel follows the other.
  State step(const Inputs& in, std::int64_t passed_ns, std::int64_t discrepancy_ns) noexcept {
    // An edge is of a button that was seen released, while the channels were closed already.
    const bool edge = in.reset_fresh && in.reset && released_ && state_ == State::wait_reset;
    released_ = in.reset_fresh && !in.reset;
    if (!in.fresh) {
      waits_ = agreed_ = false;
      state_ = fault_ ? State::discrepancy : State::no_signal;
      return state_;
    }
    // A channel that opened and closed again does not do: a contact of the other one may be welded.
    const bool agree = in.a == in.b && !(waits_ && agreed_ && in.a);
    waited_ns_ = waits_ && !agree ? waited_ns_ + passed_ns : 0;
    waits_ = !agree;
    if (agree) agreed_ = in.a;
    if (waits_ && waited_ns_ >= discrepancy_ns) fault_ = true;
    if (!in.a && !in.b) fault_ = false;
    if (fault_) {
      state_ = State::discrepancy;
    } else if (!in.a || !in.b || waits_) {
      state_ = State::stopped;
    } else if (state_ != State::permitted) {
      state_ = edge || (in.start_reset && !was_permitted_) ? State::permitted : State::wait_reset;
      was_permitted_ |= state_ == State::permitted;
    }
    return state_;
  }
  /// Back to the start: stopped, a reset is needed. A discrepancy stays.
  void trip() noexcept {
    state_ = State::stopped;
    released_ = false;
  }
  [[nodiscard]] State state() const noexcept { return state_; }

 private:
  State state_ = State::stopped;
  bool was_permitted_ = false;
  bool fault_ = false;
  bool agreed_ = false;    // what both channels were when they last agreed
  bool waits_ = false;     // one channel has changed, and the other has not followed yet
  bool released_ = false;  // the button, at the last step
  std::int64_t waited_ns_ = 0;
};

}  // namespace emergency_stop
