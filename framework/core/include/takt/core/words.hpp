// Helpers for the texts of messages. They quote input so that it cannot break a message into several lines,
// and suggest corrections of misspelled words. Not for real-time threads, because all functions allocate
// memory.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace takt {

/// Returns the text in single quotes on one line. Control characters become \n or \x1b, bytes that are not
/// UTF-8 become \xNN, and the middle of a long text is omitted. The function is not called quoted(), because
/// overload resolution would prefer std::quoted.
std::string in_quotes(std::string_view text);

/// Like in_quotes(), but without the quotes.
std::string brief(std::string_view text);

/// Like brief(), but never shortens the text. Used for paths.
std::string on_one_line(std::string_view text);

/// Returns "FILE:LINE" for the `where` of a Problem, or "line LINE" if `file` is empty. A line below 1 is
/// shown as 1.
std::string place(std::string_view file, int line);

/// Returns the choice that `word` most likely misspells; empty if no choice is similar. Ignores case.
/// Compares only with the first 1000 choices.
std::string_view nearest(std::string_view word, const std::vector<std::string_view>& choices);

/// Lists the choices, for example "a, b or c". Lists each choice once, and only the first 20.
std::string one_of(const std::vector<std::string_view>& all);

/// Returns the fix of a problem for a word that is not one of the choices: "did you mean b?" or, if no choice
/// is similar, "use a, b or c".
std::string suggestion(std::string_view word, const std::vector<std::string_view>& choices);

/// The length in bytes of the UTF-8 character at the start of `text`; 0 if the text is empty or does not
/// start with a valid character (overlong, a surrogate, or cut off).
std::size_t utf8_length(std::string_view text);

}  // namespace takt
