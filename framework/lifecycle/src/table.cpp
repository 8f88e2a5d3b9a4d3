#include <takt/lifecycle/table.hpp>

namespace takt::lifecycle {

const char* to_text(State state) noexcept {
  switch (state) {
    case State::idle:
      return "IDLE";
    case State::initialize:
      return "INITIALIZE";
    case State::start:
      return "START";
    case State::executing:
      return "EXECUTING";
    case State::recover:
      return "RECOVER";
    case State::destruct:
      return "DESTRUCT";
  }
  return "?";
}

const char* to_text(Event event) noexcept {
  switch (event) {
    case Event::initialize:
      return "initialize";
    case Event::start:
      return "start";
    case Event::run:
      return "run";
    case Event::stop:
      return "stop";
    case Event::error:
      return "error";
    case Event::recover:
      return "recover";
    case Event::give_up:
      return "give up";
    case Event::destruct:
      return "destruct";
    case Event::reset:
      return "reset";
  }
  return "?";
}

std::optional<State> next(State state, Event event, State before_error) noexcept {
  using enum State;
  const auto from = [state](State expected, State to) {
    return state == expected ? std::optional{to} : std::nullopt;
  };
  switch (event) {
    case Event::initialize:
      return from(idle, initialize);
    case Event::start:
      return from(initialize, start);
    case Event::run:
      return from(start, executing);
    case Event::stop:
      return from(executing, start);
    case Event::error:
      if (state == initialize || state == start || state == executing) return recover;
      return std::nullopt;
    case Event::recover:
      return from(recover, before_error == executing ? executing : start);
    case Event::give_up:
      return from(recover, destruct);
    case Event::destruct:
      return state == destruct ? std::nullopt : std::optional{destruct};
    case Event::reset:
      return from(destruct, idle);
  }
  return std::nullopt;
}

}  // namespace takt::lifecycle
