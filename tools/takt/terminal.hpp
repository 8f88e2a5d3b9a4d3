// The terminal that a report goes to.
#pragma once

#include "style.hpp"

namespace takt::tool {

/// Colour where standard output is a terminal and NO_COLOR is not set.
Style terminal_style();

}  // namespace takt::tool
