#include "terminal.hpp"

#include <takt/os/environment.hpp>
#include <takt/os/files.hpp>

namespace takt::tool {

Style terminal_style() { return {.colour = os::output_is_terminal() && os::environment("NO_COLOR").empty()}; }

}  // namespace takt::tool
