// The lifecycle of a module: six states, and every event that leads from one to another. This table is the
// only place that defines the steps; all code that changes a state uses it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace takt::lifecycle {

enum class State : std::uint8_t {
  idle,        ///< loaded; none of its hooks has run
  initialize,  ///< initialize(property) succeeded
  start,       ///< start() succeeded; ready, but not released
  executing,   ///< the scheduler calls or releases it
  recover,     ///< an error took the module out of the tables; recover() is tried
  destruct,    ///< destruct() was called; the module runs again only after a reset
};

enum class Event : std::uint8_t {
  initialize,  ///< IDLE -> INITIALIZE
  start,       ///< INITIALIZE -> START
  run,         ///< START -> EXECUTING, with the first row that names the module
  stop,        ///< EXECUTING -> START, after the row has ended
  error,       ///< INITIALIZE, START, EXECUTING -> RECOVER
  recover,     ///< RECOVER -> EXECUTING if the error occurred there, else START
  give_up,     ///< RECOVER -> DESTRUCT
  destruct,    ///< any but DESTRUCT -> DESTRUCT
  reset,       ///< DESTRUCT -> IDLE: the module is loaded again
};

inline constexpr std::array kStates{State::idle,      State::initialize, State::start,
                                    State::executing, State::recover,    State::destruct};
inline constexpr std::array kEvents{Event::initialize, Event::start,    Event::run,
                                    Event::stop,       Event::error,    Event::recover,
                                    Event::give_up,    Event::destruct, Event::reset};

/// "IDLE", "EXECUTING", ...: the text in reports and on the wire.
const char* to_text(State state) noexcept;
/// "initialize", "give up", ...
const char* to_text(Event event) noexcept;

/// The state that `event` leads to from `state`; none if the event is not allowed there. `before_error` is
/// the state in which the last error occurred; it matters only for `recover`. Pure; any thread may call it.
std::optional<State> next(State state, Event event, State before_error) noexcept;

}  // namespace takt::lifecycle
