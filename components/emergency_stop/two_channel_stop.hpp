// The logic of an emergency stop with two channels. For real-time threads.
#pragma once

#include <cstdint>

namespace emergency_stop {

enum class State : std::uint8_t {
  permitted = 0,    ///< running is permitted
  stopped = 1,      ///< a channel is open, or was open and the other has not followed
  wait_reset = 2,   ///< both channels are closed; a reset permits running
  discrepancy = 3,  ///< a channel did not follow the other; both must open first
  no_signal = 4,    ///< a channel has no sample, or only one that is too old
};

/// A closed (true) channel requests no stop. The logic follows PLCopen Safety: SF_Equivalent for the two
/// channels, SF_EmergencyStop for the rest. It needs a manual reset, also after the start unless start_reset
/// is true.
class TwoChannelStop {
 public:
  struct Inputs {
    bool a = false, b = false;  ///< closed
    bool fresh = false;         ///< both channels have a recent sample
    bool reset = false;         ///< the button
    bool reset_fresh = false;   ///< the button has a recent sample
    bool start_reset = false;   ///< the first time needs no reset
  };

  /// `passed_ns`: time since the last step. `discrepancy_ns`: one channel must follow the other within it.
  State step(const Inputs& in, std::int64_t passed_ns, std::int64_t discrepancy_ns) noexcept {
    // An edge counts only if the button was seen released and the channels were already closed.
    const bool edge = in.reset_fresh && in.reset && released_ && state_ == State::wait_reset;
    released_ = in.reset_fresh && !in.reset;
    if (!in.fresh) {
      waits_ = agreed_ = false;
      state_ = fault_ ? State::discrepancy : State::no_signal;
      return state_;
    }
    // It is not enough that one channel opened and closed again, because the contact of the other channel may
    // be welded.
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
  /// Stops. After that a reset is needed, as after the start. A discrepancy stays.
  void trip() noexcept {
    state_ = State::stopped;
    released_ = false;
  }
  [[nodiscard]] State state() const noexcept { return state_; }

 private:
  State state_ = State::stopped;
  bool was_permitted_ = false;
  bool fault_ = false;
  bool agreed_ = false;    // the common value when the channels last agreed
  bool waits_ = false;     // one channel has changed and the other has not followed yet
  bool released_ = false;  // the button was seen released at the last step
  std::int64_t waited_ns_ = 0;
};

}  // namespace emergency_stop
