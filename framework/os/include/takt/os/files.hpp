// What kind of file something is, and files that must be whole.
#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include <takt/core/result.hpp>

namespace takt::os {

/// A regular file that this user may execute.
bool is_executable(const std::string& path);

/// An ELF shared object of this machine's kind that is not a program. (A program built as PIE has an
/// interpreter.)
bool is_shared_object(const std::string& path);

/// A section of an ELF file by its name; none where the file is none, or has no such section with something
/// in it. At most 16 MiB.
std::optional<std::string> read_section(const std::string& path, const std::string& name);

/// Replaces a file so that whoever reads it, after a loss of power too, finds the old content or the new one
/// and never a part. Makes its folder if there is none.
enum class Readers { owner, everybody };
Result<void> replace_file(const std::string& path, const std::string& content,
                          Readers readers = Readers::owner);
/// What is in a file; none where there is no such file. Fails when it cannot be read or has more than `most`
/// bytes.
Result<std::optional<std::string>> read_file(const std::string& path, std::size_t most);
/// All of a file of /proc or /sys, which has no size before it is read, without line feeds and zeros at its
/// end. Empty where it cannot be read, or was the file of a thread that ends meanwhile.
std::string text_of(const std::string& path);
/// It is gone afterwards, also when there was none.
Result<void> remove_file(const std::string& path);

/// What others than its owner may do with a file or folder. None where there is none.
struct Rights {
  bool is_folder = false;
  bool group_reads = false;
  bool group_writes = false;
  bool others_read = false;
  bool others_write = false;
};
std::optional<Rights> rights_of(const std::string& path);
/// A folder that its owner alone may enter, with those above it as usual. Fails where there is a file, and
/// where somebody else may enter one that is there.
Result<void> make_private_folder(const std::string& path);

/// Whether standard output is a terminal.
bool output_is_terminal();

}  // namespace takt::os
