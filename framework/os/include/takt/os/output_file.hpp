// Writes a file that a user has named, such as a drawing or a table.
//
// Unlike replace_file(), an output file never creates its folder, because a missing folder is more likely a
// typing error. It has the usual access rights, which the umask limits.
#pragma once

#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include <takt/core/result.hpp>

namespace takt::os {

/// Returns the problem that a file cannot be created because its folder does not exist; none if the folder
/// exists.
std::optional<Problem> missing_folder(const std::string& path);

class OutputFile {
 public:
  /// Creates the file, or empties an existing file. Writes into devices and FIFOs, and through links. For
  /// /dev/stdout, continues standard output where it is. Fails if the folder does not exist, or if this user
  /// may not write to the file.
  static Result<OutputFile> open(const std::string& path);
  /// Like open(), but "-" means standard output.
  static Result<OutputFile> open_or_standard(const std::string& path);

  void write(const std::string& text);
  /// Fails if any of the writes has failed. Call it once, after the last write.
  Result<void> close();

 private:
  struct Close {
    void operator()(std::FILE* file) const;
  };
  OutputFile(std::string path, std::FILE* file) : path_(std::move(path)), file_(file) {}

  std::string path_;
  std::unique_ptr<std::FILE, Close> file_;
  bool whole_ = true;
};

/// Writes a whole file at once.
Result<void> write_output(const std::string& path, const std::string& content);

}  // namespace takt::os
