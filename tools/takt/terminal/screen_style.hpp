// How a terminal that is drawn on shows things.
#pragma once

namespace takt::tool {

struct ScreenStyle {
  bool colour = false;   ///< ANSI escapes; never counted in the width
  bool unicode = false;  ///< it shows more than ASCII
};

/// Colour where standard output is a terminal and NO_COLOR is not set; Unicode where the locale has it.
ScreenStyle screen_style();

/// Whether the locale that was chosen (LC_ALL, LC_CTYPE, LANG) is one of UTF-8.
bool is_utf8();

}  // namespace takt::tool
