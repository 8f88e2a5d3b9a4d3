// The mathematics of the component emergency_stop: the logic of an emergency stop with two channels.
// Real-time threads may use everything here.
#pragma once

#include <cstdint>

namespace emergency_stop {

enum class State : std::uint8_t {
  permitted = 0,    ///< the machine may run
  stopped = 1,      ///< a channel is open, or has been open while the other stayed closed
  wait_reset = 2,   ///< both channels are closed; a reset permits running
  discrepancy = 3,  ///< one channel did not follow the other in time; both must open first
  no_signal = 4,    ///< a channel has no sample, or its newest sample is too old
};

/// Decides whether the machine may run. An open channel (false) requests a stop. The logic follows PLCopen
/// Safety: SF_Equivalent for the two channels, and SF_EmergencyStop for the reset. The logic needs a manual
/// reset after each stop, and also after the start unless start_reset is true.
class TwoChannelStop {
 public:
  struct Inputs {
    bool a = false, b = false;  ///< true: the channel is closed
    bool fresh = false;         ///< true: both channels have a recent sample
    bool reset = false;         ///< true: the reset button is pressed
    bool reset_fresh = false;   ///< true: the reset button has a recent sample
    bool start_reset = false;   ///< true: the first permission needs no reset
  };

  /// Makes one step and returns the new state. `passed_ns`: time since the last step. `discrepancy_ns`: time
  /// within which one channel must follow the other.
  State step(const Inputs& in, std::int64_t passed_ns, std::int64_t discrepancy_ns) noexcept {
    // An edge counts only if the button was released at the last step and the channels were already closed.
    const bool edge = in.reset_fresh && in.reset && released_ && state_ == State::wait_reset;
    released_ = in.reset_fresh && !in.reset;
    if (!in.fresh) {
      waits_ = agreed_ = false;
      state_ = fault_ ? State::discrepancy : State::no_signal;
      return state_;
    }
    // If one channel opens and closes while the other stays closed, the channels do not agree, because the
    // contact of the other channel may be welded.
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
  /// Withdraws the permission. The next permission needs a reset, as after the start. A discrepancy remains.
  void trip() noexcept {
    state_ = State::stopped;
    released_ = false;
  }
  [[nodiscard]] State state() const noexcept { return state_; }

 private:
  State state_ = State::stopped;
  bool was_permitted_ = false;
  bool fault_ = false;
  bool agreed_ = false;    // the common value of the channels when they last agreed
  bool waits_ = false;     // true: one channel has changed and the other has not followed yet
  bool released_ = false;  // true: the reset button was released at the last step
  std::int64_t waited_ns_ = 0;
};

}  // namespace emergency_stop
