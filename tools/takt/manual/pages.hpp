// Makes the manual pages and the bash completion of a program from its command line definition.
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace CLI {
class App;
}

namespace takt::tool {

/// The hidden command with which the build writes the pages of a program: PROGRAM write-pages FOLDER.
inline constexpr const char* kWritePages = "write-pages";

/// The manual page of the program (`command` empty) or of one of its commands, as roff with the man macros.
/// The page of a command also describes its subcommands.
std::string manual_page(const CLI::App& program, const std::string& command, int section);

/// A bash script that completes commands, options and file names.
std::string bash_completion(const CLI::App& program);

/// Removes the type "TEXT" of arguments from --help.
void tidy_help(CLI::App& program);

/// Makes wrong usage print the error and the usage line, not the whole help.
void shorten_errors(CLI::App& program);

/// Writes FOLDER/man/manN/NAME.N for the program and each of its commands, and FOLDER/completions/NAME.
/// Returns the exit status; prints the reason for a failure on standard error.
int write_pages(const CLI::App& program, const std::string& folder, int section);

}  // namespace takt::tool
