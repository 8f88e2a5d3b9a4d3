#include <takt/os/output_file.hpp>

#include <cerrno>
#include <filesystem>

#include "error.hpp"

namespace takt::os {

std::optional<Problem> missing_folder(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::path{path}.parent_path();
  std::error_code error;
  if (folder.empty() || std::filesystem::exists(folder, error) || error) return std::nullopt;
  return Problem{path, "cannot be written: the folder " + folder.string() + " does not exist",
                 "create it, or choose another file"};
}

Result<OutputFile> OutputFile::open(const std::string& path) {
  // Opening such a path would not work for a socket, and would overwrite the beginning of a regular file.
  if (path == "/dev/stdout" || path == "/dev/fd/1" || path == "/proc/self/fd/1")
    return OutputFile{"standard output", stdout};
  if (std::FILE* const file = std::fopen(path.c_str(), "wbe"); file != nullptr) return OutputFile{path, file};
  const int error = errno;
  if (const auto missing = missing_folder(path)) return *missing;
  Problem problem = error_problem("cannot be written", error, advice_to_write(error));
  problem.where = path;
  return problem;
}

Result<OutputFile> OutputFile::open_or_standard(const std::string& path) {
  return path == "-" ? OutputFile{"standard output", stdout} : open(path);
}

void OutputFile::Close::operator()(std::FILE* file) const {
  if (file != stdout) std::fclose(file);
}

void OutputFile::write(const std::string& text) {
  whole_ &= std::fwrite(text.data(), 1, text.size(), file_.get()) == text.size();
}

Result<void> OutputFile::close() {
  std::FILE* const file = file_.release();
  whole_ &= std::fflush(file) == 0;
  if (file != stdout) whole_ &= std::fclose(file) == 0;
  if (whole_) return {};
  return Problem{path_, "was not written completely", "check whether the disk is full"};
}

Result<void> write_output(const std::string& path, const std::string& content) {
  auto file = OutputFile::open(path);
  if (!file) return file.problems();
  file->write(content);
  return file->close();
}

}  // namespace takt::os
