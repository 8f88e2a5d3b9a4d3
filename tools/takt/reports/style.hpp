// How a report for a person is printed. The command line decides it once, from the terminal it writes to.
#pragma once

#include <cstddef>

namespace takt::tool {

struct Style {
  bool colour = false;      ///< ANSI escapes; never counted in the width
  std::size_t width = 100;  ///< columns; a report uses 80 to 100 of them, whatever this says
};

}  // namespace takt::tool
