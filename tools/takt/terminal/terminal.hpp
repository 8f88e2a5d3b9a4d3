// Writes reports to standard output, in colour if it is a terminal.
#pragma once

#include <string>

#include "reports/style.hpp"

namespace takt::tool {

/// The style of reports on standard output: in colour if it is a terminal and NO_COLOR is not set.
Style terminal_style();

/// Writes to standard output. If that fails (disk full, pipe closed), prints an error on standard error and
/// returns false.
bool print(const std::string& text);

/// The exit status of a command that ends because nobody reads its standard output any longer. In a shell, a
/// program that is ended by SIGPIPE has the same status.
constexpr int kNoReader = 128 + 13;

}  // namespace takt::tool
