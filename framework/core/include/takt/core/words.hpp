// Helpers for the texts of messages. They quote input from outside so that it cannot break a message into
// several lines, and suggest corrections of misspelled words. Not for real-time threads, because all
// functions allocate memory.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace takt {

/// Returns the text in single quotes on one line. Control characters become escapes such as \n or \x1b, bytes
/// that are not UTF-8 become \xNN, and the middle of a long text is omitted. The function is not called
/// quoted(), because overload resolution would prefer std::quoted.
std::string in_quotes(std::string_view text);

/// Does the same as in_quotes(), but without the quotes.
std::string brief(std::string_view text);

/// Does the same as brief(), but never shortens the text. Used for paths.
std::string on_one_line(std::string_view text);

/// Returns a control character of a text in XML as a reference such as "&#x202e;". XML has no references to
/// most characters below U+0020, so these become escapes as in on_one_line(), as do invalid bytes.
std::string xml_reference(std::string_view character);

/// Returns "FILE:LINE" for the `where` of a Problem, or "line LINE" if `file` is empty. A line number below 1
/// becomes 1.
std::string location(std::string_view file, int line);

/// Returns the choice that is most similar to `word`; empty if no choice is similar. Ignores case. Compares
/// `word` only with the first 1000 choices.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& choices);

/// Returns the choices as a list, for example "a, b or c". Lists each choice once, and at most 20 choices.
std::string one_of(const std::vector<std::string_view>& all);

/// Returns the text for Problem::fix if `word` is not one of the choices: "did you mean b?" or, if no choice
/// is similar, "use a, b or c".
std::string suggestion(std::string_view word, const std::vector<std::string_view>& choices);

/// Returns the length in bytes of the UTF-8 character at the start of `text`. Returns 0 if the text is empty,
/// or if the character is invalid (for example overlong, a surrogate, or cut off).
std::size_t utf8_length(std::string_view text);

}  // namespace takt
