// The lifecycle state of one module, its previous state, and the number of state changes so far.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/result.hpp>
#include <takt/lifecycle/table.hpp>

namespace takt::lifecycle {

/// One change of a module's state. `sequence` numbers the changes of the module from 1 without gaps, so an
/// observer notices changes that it missed.
struct Transition {
  State from = State::idle;
  State to = State::idle;
  Event event = Event::initialize;
  std::uint64_t sequence = 0;
};

/// Holds the state of one module, and changes it only as the table allows. Only one thread at a time may use
/// this object.
class Machine {
 public:
  [[nodiscard]] State state() const noexcept { return state_; }
  [[nodiscard]] State previous() const noexcept { return previous_; }
  [[nodiscard]] std::uint64_t sequence() const noexcept { return sequence_; }
  [[nodiscard]] bool accepts(Event event) const noexcept {
    return next(state_, event, before_error_).has_value();
  }

  /// Changes the state as the table states for `event`. If the event is not allowed in the current state,
  /// fails and changes nothing; the problem names the current state and the states in which the event is
  /// allowed.
  Result<Transition> apply(Event event);

 private:
  State state_ = State::idle;
  State previous_ = State::idle;
  State before_error_ = State::start;
  std::uint64_t sequence_ = 0;
};

}  // namespace takt::lifecycle
