// The style of a text report: its colours and its width. The program chooses it once, for the terminal to
// which it writes.
#pragma once

#include <cstddef>

namespace takt::tool {

struct Style {
  bool colour = false;      ///< use colours; the ANSI escapes for colours do not count in the width
  std::size_t width = 100;  ///< width in columns; Page uses at least 80 and at most 100
};

}  // namespace takt::tool
