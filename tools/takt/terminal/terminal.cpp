#include "terminal/terminal.hpp"

#include <cstdio>

#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>

namespace takt::tool {

Style terminal_style() { return {.colour = os::output_is_terminal() && os::environment("NO_COLOR").empty()}; }

bool print(const std::string& text) {
  const bool written =
      std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  if (!written) std::fprintf(stderr, "error: cannot write the report to standard output\n");
  return written;
}

}  // namespace takt::tool
