// What a terminal can show: colours and Unicode.
#pragma once

namespace takt::tool {

struct ScreenStyle {
  bool colour = false;   ///< ANSI escapes; never counted in the width
  bool unicode = false;  ///< the terminal shows more than ASCII
};

/// Colour if standard output is a terminal and NO_COLOR is not set; Unicode if the locale is UTF-8.
ScreenStyle screen_style();

/// Whether the locale (LC_ALL, else LC_CTYPE, else LANG) is a UTF-8 locale.
bool is_utf8();

}  // namespace takt::tool
