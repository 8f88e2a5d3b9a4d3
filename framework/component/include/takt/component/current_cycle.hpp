// The cycle that a thread serves while it calls a hook. Functions in the C form have no arguments, so
// takt_cycle(), takt_release_ns() and takt_period_ns() find the cycle here.
#pragma once

#include <takt/component.hpp>

namespace takt {

/// Sets the cycle that this thread serves from now on; null: none. The cycle must stay valid until the next
/// call. In a hook without a release, only `start` and the module's own `period` are set. A real-time thread
/// may call it.
void serve_cycle(const Cycle* cycle) noexcept;
/// Returns the cycle that this thread serves; null: none. A real-time thread may call it.
const Cycle* served_cycle() noexcept;

}  // namespace takt
