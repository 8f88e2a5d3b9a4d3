// The life of a module: six states, and every event that leads from one to another. This table is the only
// place that knows; who wants to change a state asks it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace takt::lifecycle {

enum class State : std::uint8_t {
  idle,        ///< loaded; nothing of it has run
  initialize,  ///< initialize(property) succeeded
  start,       ///< start() succeeded; ready, not being released
  executing,   ///< the scheduler calls or releases it
  recover,     ///< an error took it out of the tables; recover() is tried
  destruct,    ///< destruct() was called; it never runs again unless reset
};

enum class Event : std::uint8_t {
  initialize,  ///< IDLE -> INITIALIZE
  start,       ///< INITIALIZE -> START
  run,         ///< START -> EXECUTING: the next row named it
  stop,        ///< EXECUTING -> START: the row ended first
  error,       ///< INITIALIZE, START, EXECUTING -> RECOVER
  recover,     ///< RECOVER -> where it was before the error, if that was START or EXECUTING, else START
  give_up,     ///< RECOVER -> DESTRUCT
  destruct,    ///< any but DESTRUCT -> DESTRUCT
  reset,       ///< DESTRUCT -> IDLE: loaded afresh
};

inline constexpr std::array kStates{State::idle,      State::initialize, State::start,
                                    State::executing, State::recover,    State::destruct};
inline constexpr std::array kEvents{Event::initialize, Event::start,    Event::run,
                                    Event::stop,       Event::error,    Event::recover,
                                    Event::give_up,    Event::destruct, Event::reset};

/// "IDLE", "EXECUTING": as in reports and on the wire.
const char* to_text(State state) noexcept;
/// "initialize", "give up".
const char* to_text(Event event) noexcept;

/// Where `event` leads from `state`; none when the table refuses it. `before_error` is the state that the
/// last error met and matters only for `recover`. Pure; any thread.
std::optional<State> next(State state, Event event, State before_error) noexcept;

}  // namespace takt::lifecycle
