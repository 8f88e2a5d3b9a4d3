// The style of a text report. The command line sets it once, from the terminal to which it writes.
#pragma once

#include <cstddef>

namespace takt::tool {

struct Style {
  bool colour = false;      ///< ANSI escapes; never counted in the width
  std::size_t width = 100;  ///< columns; clamped to 80 to 100
};

}  // namespace takt::tool
