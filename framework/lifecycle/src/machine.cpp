#include <takt/lifecycle/machine.hpp>

namespace takt::lifecycle {

Result<Transition> Machine::apply(Event event) {
  const auto to = next(state_, event, before_error_);
  if (!to) {
    std::string allowed;
    for (State state : kStates) {
      if (!next(state, event, before_error_)) continue;
      if (!allowed.empty()) allowed += " or ";
      allowed += to_text(state);
    }
    return fail(std::string{to_text(event)} + " is not allowed in state " + to_text(state_),
                "it is allowed in " + allowed);
  }
  if (event == Event::error) before_error_ = state_;
  previous_ = state_;
  state_ = *to;
  ++sequence_;
  return Transition{.from = previous_, .to = state_, .event = event, .sequence = sequence_};
}

}  // namespace takt::lifecycle
