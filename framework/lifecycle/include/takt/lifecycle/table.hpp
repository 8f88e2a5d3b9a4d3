// The lifecycle of a module: six states, and every event that leads from one state to another. Only this
// table defines the state changes; all code that changes a state uses it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

namespace takt::lifecycle {

enum class State : std::uint8_t {
  idle,        ///< the module is loaded, but none of its hooks has run
  initialize,  ///< initialize(property) succeeded
  start,       ///< start() succeeded; the module is ready, but does not run yet
  executing,   ///< Takt calls or releases the module, or its non-real-time program runs
  recover,     ///< an error removed the module from the tables; Takt calls recover()
  destruct,    ///< destruct() was called; the module can run again only after a reset
};

enum class Event : std::uint8_t {
  initialize,  ///< IDLE -> INITIALIZE
  start,       ///< INITIALIZE -> START
  run,         ///< START -> EXECUTING, at the first row that contains the module
  stop,        ///< EXECUTING -> START, at the end of a row
  error,       ///< INITIALIZE, START, EXECUTING -> RECOVER
  recover,     ///< RECOVER -> EXECUTING if the error occurred in EXECUTING, otherwise START
  give_up,     ///< RECOVER -> DESTRUCT
  destruct,    ///< any state except DESTRUCT -> DESTRUCT
  reset,       ///< DESTRUCT -> IDLE: the module is loaded again
};

inline constexpr std::array kStates{State::idle,      State::initialize, State::start,
                                    State::executing, State::recover,    State::destruct};
inline constexpr std::array kEvents{Event::initialize, Event::start,    Event::run,
                                    Event::stop,       Event::error,    Event::recover,
                                    Event::give_up,    Event::destruct, Event::reset};

/// The state as text in reports and on the wire, for example "IDLE" or "EXECUTING".
const char* to_text(State state) noexcept;
/// The event as text, for example "initialize" or "give up".
const char* to_text(Event event) noexcept;

/// Returns the state to which `event` leads from `state`; empty if the event is not allowed in `state`.
/// `before_error` is the state in which the last error occurred; only `recover` uses it. Pure function; any
/// thread may call it.
std::optional<State> next(State state, Event event, State before_error) noexcept;

}  // namespace takt::lifecycle
