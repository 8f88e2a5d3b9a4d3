// The words of a message: what somebody wrote, shown so that it cannot break the line it stands in, and the
// guess at what was meant. Not for real-time threads: everything here allocates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace takt {

/// The text in '' as part of one line: control characters as \n or \x1b, bytes that are not UTF-8 as \xNN,
/// the middle of a long text cut out. Not named quoted(), which std::quoted would win over.
std::string in_quotes(std::string_view text);

/// The same without the ''.
std::string brief(std::string_view text);

/// The same in full length, for a path.
std::string on_one_line(std::string_view text);

/// "FILE:LINE", the `where` of a Problem; "line LINE" without a file. A line below 1 counts as 1.
std::string place(std::string_view file, int line);

/// The choice that `word` is most likely a slip of; empty when none is near. Upper and lower case are near.
/// Looks at the first 1000 choices.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& choices);

/// "a, b or c". Of many choices only the first are named; one that is given twice is named once.
std::string one_of(const std::vector<std::string_view>& all);

/// The fix for a word that is none of the choices: "did you mean b?", else "it can be a, b or c".
std::string suggestion(std::string_view word, const std::vector<std::string_view>& choices);

/// The length of the UTF-8 character that `text` starts with; 0 when it is none (overlong, surrogate, cut
/// off, empty).
std::size_t utf8_length(std::string_view text);

}  // namespace takt
