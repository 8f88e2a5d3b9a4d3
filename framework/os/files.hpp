// What kind of file something is.
#pragma once

#include <string>

namespace takt::os {

/// A regular file that this user may execute.
bool is_executable(const std::string& path);

/// An ELF shared object of this machine's kind that is not a program. (A program built as PIE has an
/// interpreter.)
bool is_shared_object(const std::string& path);

/// Whether standard output is a terminal.
bool output_is_terminal();

}  // namespace takt::os
