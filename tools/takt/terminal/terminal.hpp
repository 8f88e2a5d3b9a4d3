// Writes reports to standard output, in colour if it is a terminal, and lines to standard error.
#pragma once

#include <string>
#include <string_view>

#include "reports/style.hpp"

namespace takt::tool {

/// The style of reports on standard output: in colour if it is a terminal and NO_COLOR is not set.
Style terminal_style();

/// Writes to standard output. Escapes control characters other than line feeds, tabs and colours, because
/// names and texts from components, files and the network must not control the terminal. Returns false if
/// writing fails (disk full, pipe closed); finish() then reports the reason.
bool print(const std::string& text);

/// Like print(), but writes the text unchanged: for texts that control the terminal, such as the screen of
/// takt watch.
bool print_unchanged(std::string_view text);

/// Writes one line to standard error. Escapes all control characters.
void tell(std::string_view line);

/// The exit status of a command that ends because nobody reads its standard output any longer. In a shell, a
/// program that is ended by SIGPIPE has the same status.
constexpr int kNoReader = 128 + 13;

/// Returns the exit status of a program that would end with `status`, but must not succeed if print() has
/// failed. Writes the reason to standard error, unless the reader of standard output has closed its pipe.
int finish(int status);

}  // namespace takt::tool
