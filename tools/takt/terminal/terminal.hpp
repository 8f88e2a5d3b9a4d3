// The terminal that a report goes to.
#pragma once

#include <string>

#include "reports/style.hpp"

namespace takt::tool {

/// Colour where standard output is a terminal and NO_COLOR is not set.
Style terminal_style();

/// Writes to standard output; false and a reason on standard error when it is full or closed.
bool print(const std::string& text);

}  // namespace takt::tool
