// What a module asks for while one of its hooks is called: functions in the C form have no arguments, and
// ports stamp what they write with the time at which the call began.
#pragma once

#include <takt/component.hpp>

namespace takt {

/// The release that this thread serves from now on; null: none. Of a hook that is none, only `start` and the
/// module's own `period` are set.
/// The cycle outlives the serving. Real-time.
void serve_cycle(const Cycle* cycle) noexcept;
/// What this thread serves; null: nothing. Real-time.
const Cycle* served_cycle() noexcept;

}  // namespace takt
