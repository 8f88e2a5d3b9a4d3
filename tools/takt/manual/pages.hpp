// The manual pages and the completion of a program, made of what its --help is made of.
#pragma once

#include <string>

#include <takt/core/result.hpp>

namespace CLI {
class App;
}

namespace takt::tool {

/// What the build calls a program with to have its pages written: PROGRAM write-pages FOLDER. No user needs
/// it.
inline constexpr const char* kWritePages = "write-pages";

/// The manual page of the program itself (`command` empty) or of one of its commands; those within a command
/// have their place on its page. As roff with the man macros.
std::string manual_page(const CLI::App& program, const std::string& command, int section);

/// A script for bash that completes commands, options and files.
std::string bash_completion(const CLI::App& program);

/// Labels that say nothing are left out of --help.
void tidy_help(CLI::App& program);

/// Wrong usage is told with how the command is used, and no more.
void shorten_errors(CLI::App& program);

/// FOLDER/man/manN/NAME.N for the program and each of its commands, and FOLDER/completions/NAME. Returns the
/// exit status, with a reason on standard error.
int write_pages(const CLI::App& program, const std::string& folder, int section);

}  // namespace takt::tool
