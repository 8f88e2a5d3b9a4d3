// Makes the manual pages and the bash completion of a program from its command line definition.
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace takt::tool {

/// The hidden command with which the build makes a program write its manual pages and completions: PROGRAM
/// write-pages FOLDER.
inline constexpr const char* kWritePages = "write-pages";

/// The manual page of one command, or of the whole program if `command` is empty, as roff with the man
/// macros. The page of a command also describes its subcommands.
std::string manual_page(const CLI::App& program, const std::string& command, int section);

/// A bash script that completes the program's commands, options and file names.
std::string bash_completion(const CLI::App& program);

/// Removes the word "TEXT", which CLI11 adds as the type of an argument, from --help.
void tidy_help(CLI::App& program);

/// Makes the program print only the error and the usage line after wrong usage, not the whole help.
void shorten_errors(CLI::App& program);

/// Prints the help or version that the command line asks for, or what is wrong with it. Returns the exit
/// status.
int explain(const CLI::App& program, const CLI::ParseError& error);

/// Writes FOLDER/man/manN/NAME.N for the program and each of its commands, and FOLDER/completions/NAME.
/// Returns the exit status. If writing fails, prints the reason on standard error.
int write_pages(const CLI::App& program, const std::string& folder, int section);

}  // namespace takt::tool
