// One module's place in the table, and what happened to it last.
#pragma once

#include <cstdint>
#include <string>

#include <takt/core/result.hpp>
#include <takt/lifecycle/table.hpp>

namespace takt::lifecycle {

/// One step that was taken. `sequence` counts the steps of one module from 1 without gaps, so an observer
/// knows what it missed.
struct Transition {
  State from = State::idle;
  State to = State::idle;
  Event event = Event::initialize;
  std::uint64_t sequence = 0;
};

/// Holds a state that nothing but the table changes. One thread at a time.
class Machine {
 public:
  [[nodiscard]] State state() const noexcept { return state_; }
  [[nodiscard]] State previous() const noexcept { return previous_; }
  [[nodiscard]] std::uint64_t sequence() const noexcept { return sequence_; }
  [[nodiscard]] bool accepts(Event event) const noexcept {
    return next(state_, event, before_error_).has_value();
  }

  /// Takes the step, or refuses with the state that was met and the states from which the event is allowed;
  /// nothing changes then.
  Result<Transition> apply(Event event);

 private:
  State state_ = State::idle;
  State previous_ = State::idle;
  State before_error_ = State::start;
  std::uint64_t sequence_ = 0;
};

}  // namespace takt::lifecycle
