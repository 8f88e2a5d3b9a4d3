#include "terminal/screen_style.hpp"

#include <algorithm>
#include <cctype>
#include <string>

#include <takt/os/environment.hpp>

#include "terminal/terminal.hpp"

namespace takt::tool {

ScreenStyle screen_style() { return {.colour = terminal_style().colour, .unicode = is_utf8()}; }

bool is_utf8() {
  // The first of these variables that is set decides, even if its locale is not installed, because the
  // variable describes the terminal.
  for (const char* name : {"LC_ALL", "LC_CTYPE", "LANG"}) {
    std::string value = os::environment(name);
    if (value.empty()) continue;
    std::transform(value.begin(), value.end(), value.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return value.find("utf-8") != std::string::npos || value.find("utf8") != std::string::npos;
  }
  return false;
}

}  // namespace takt::tool
