// Checks kinds and rights of files, and reads and replaces whole files.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <takt/core/result.hpp>

namespace takt::os {

/// Whether this is a regular file that this user may execute.
bool is_executable(const std::string& path);

/// Whether this is an ELF shared object for this machine's architecture, and not a program. (A program built
/// as PIE has an interpreter.)
bool is_shared_object(const std::string& path);

/// The content of a section of an ELF file, by its name, at most 16 MiB. None if the file is not ELF, or if
/// it has no such section with content.
std::optional<std::string> read_section(const std::string& path, const std::string& name);

/// The users that may read a file.
enum class Readers { owner, everybody };
/// Replaces a file atomically: a reader finds the complete old or new content, also after a loss of power.
/// Creates the folder if it does not exist.
Result<void> replace_file(const std::string& path, const std::string& content,
                          Readers readers = Readers::owner);
/// The content of a file; none if the file does not exist. Fails if it cannot be read or has more than `most`
/// bytes.
Result<std::optional<std::string>> read_file(const std::string& path, std::size_t most);
/// The whole content of a file of /proc or /sys, without line feeds and zeros at its end. Empty if the file
/// cannot be read, for example because its thread has ended. (Such a file has no size before it is read.)
std::string text_of(const std::string& path);
/// Removes the file. Succeeds if it does not exist.
Result<void> remove_file(const std::string& path);

/// What users other than the owner may do with a file or folder.
struct Rights {
  bool is_folder = false;
  bool group_reads = false;
  bool group_writes = false;
  bool others_read = false;
  bool others_write = false;
};
/// None if there is no such file or folder.
std::optional<Rights> rights_of(const std::string& path);
/// Creates a folder that only its owner may enter. Folders above it get the usual rights. Fails if the path
/// is a file, or an existing folder that other users may enter.
Result<void> make_private_folder(const std::string& path);

/// Whether standard output is a terminal.
bool output_is_terminal();

}  // namespace takt::os
