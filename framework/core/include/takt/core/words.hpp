// Helpers for the text of messages: input quoted so that it cannot break the line of the message, and
// suggestions for misspelled words. Not for real-time threads: everything here allocates.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace takt {

/// The text in single quotes, on one line. Control characters become \n or \x1b, bytes that are not UTF-8
/// become \xNN, and the middle of a long text is left out. Not named quoted(): overload resolution would
/// prefer std::quoted.
std::string in_quotes(std::string_view text);

/// Like in_quotes(), but without the quotes.
std::string brief(std::string_view text);

/// Like brief(), but never shortens the text. For paths.
std::string on_one_line(std::string_view text);

/// "FILE:LINE", the `where` of a Problem; "line LINE" if `file` is empty. A line below 1 becomes 1.
std::string place(std::string_view file, int line);

/// The choice that `word` most likely misspells; empty if none is similar. Ignores case. Compares with the
/// first 1000 choices only.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& choices);

/// "a, b or c". Names each choice once, and only the first 20.
std::string one_of(const std::vector<std::string_view>& all);

/// The fix for a word that is not one of the choices: "did you mean b?", else "it can be a, b or c".
std::string suggestion(std::string_view word, const std::vector<std::string_view>& choices);

/// The length in bytes of the UTF-8 character that `text` starts with. 0 if the text is empty or does not
/// start with a valid character (overlong, surrogate or cut off).
std::size_t utf8_length(std::string_view text);

}  // namespace takt
