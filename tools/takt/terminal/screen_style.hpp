// What a terminal can show: colours and Unicode.
#pragma once

namespace takt::tool {

struct ScreenStyle {
  bool colour = false;   ///< the terminal shows colours, which are ANSI escape sequences
  bool unicode = false;  ///< the terminal shows Unicode, not only ASCII
};

/// The style for this terminal: with colour if standard output is a terminal and NO_COLOR is not set, and
/// with Unicode if the locale is UTF-8.
ScreenStyle screen_style();

/// True if the locale (LC_ALL, else LC_CTYPE, else LANG) is a UTF-8 locale.
bool is_utf8();

}  // namespace takt::tool
