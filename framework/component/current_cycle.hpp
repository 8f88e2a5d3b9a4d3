// What a module in the C form asks for while its run() is called: its functions have no arguments.
#pragma once

#include <takt/component/component.hpp>

namespace takt {

/// The release that this thread serves from now on; null: none. The cycle outlives the serving. Real-time.
void serve_cycle(const Cycle* cycle) noexcept;

}  // namespace takt
