// Distinguishes characters that control a terminal from characters that a terminal only shows.
#pragma once

#include <string_view>

namespace takt {

/// Returns true if `character`, which must be one valid UTF-8 character, moves the cursor, starts an escape
/// sequence, breaks the line or changes the direction of the text. These characters are U+0000-001F,
/// U+007F-009F, the line and paragraph separators, and all characters with the Unicode property Bidi_Control.
bool is_control_character(std::string_view character) noexcept;

}  // namespace takt
