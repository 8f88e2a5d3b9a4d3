// Checks the types and access rights of files, and reads or replaces whole files.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::os {

/// Returns true if this path is a regular file that this user may execute.
bool is_executable(const std::string& path);

/// Returns true if this path is an ELF shared object for the architecture of this machine. Returns false for
/// a program, even if it is position-independent.
bool is_shared_object(const std::string& path);

/// Reads the section with this name from an ELF file; at most 16 MiB. Returns none if the file is not an ELF
/// file, if the file has no such section, or if the section is empty.
std::optional<std::string> read_section(const std::string& path, const std::string& name);

/// Returns the folders in which the loader searches for the libraries of an ELF file, as the file names them,
/// separated by ':'. Empty if it names none.
std::string library_folders(const std::string& path);

/// Returns the names of the libraries with which an ELF file is linked.
std::vector<std::string> needed_libraries(const std::string& path);

/// Who may read a file.
enum class Readers { owner, everybody };
/// Replaces the content of a file atomically: a reader always finds either the complete old content or the
/// complete new content, even after a loss of power. Creates the folder if it does not exist.
Result<void> replace_file(const std::string& path, const std::string& content,
                          Readers readers = Readers::owner);
/// Reads a file. Returns none if the file does not exist. Fails if the file cannot be read or has more than
/// `most` bytes.
Result<std::optional<std::string>> read_file(const std::string& path, std::size_t most);
/// Reads a file of /proc or /sys, and removes line feeds and zero bytes at its end. Returns an empty text if
/// the file cannot be read, for example because the thread that it describes has ended.
std::string text_of(const std::string& path);
/// Removes the file. Also succeeds if the file does not exist.
Result<void> remove_file(const std::string& path);

/// What users other than the owner may do with a file or folder, and whether it is a folder.
struct Rights {
  bool is_folder = false;
  bool group_reads = false;
  bool group_writes = false;
  bool others_read = false;
  bool others_write = false;
};
/// Reads the rights of a file or folder. Returns none if it does not exist.
std::optional<Rights> rights_of(const std::string& path);
/// Creates a folder that only its owner may enter. Parent folders that do not exist are created with the
/// usual rights. Fails if the path is a file, an existing folder that other users may enter, or a folder that
/// other users can replace (check_writers()).
Result<void> make_private_folder(const std::string& path);

/// Returns true if standard output is a terminal.
bool output_is_terminal();
/// Returns true if standard output is a pipe or socket that nobody reads any longer. Does not wait.
bool output_has_no_reader();

}  // namespace takt::os
