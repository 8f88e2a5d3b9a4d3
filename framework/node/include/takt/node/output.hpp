// Reads the output of a child process line by line.
#pragma once

#include <deque>
#include <functional>
#include <string>

#include <takt/os/fd.hpp>

namespace takt::node {

/// Splits a stream of bytes into lines of limited length. Each line is safe to print: tabs become spaces, and
/// on_one_line() escapes control characters and invalid UTF-8.
class Lines {
 public:
  using Line = std::function<void(const std::string&)>;
  static constexpr std::size_t kLongest = 2000;

  void add(const std::string& bytes, const Line& line);
  /// Passes the last line to `line`, if the line has no line break at its end.
  void finish(const Line& line);

 private:
  std::string partial_;
};

/// Reads the standard output and standard error of a child process. Keeps the last lines, which may explain
/// why the process ended.
class Output {
 public:
  static constexpr std::size_t kKept = 20;

  Output() = default;
  Output(os::Fd output, os::Fd error) : output_(std::move(output)), error_(std::move(error)) {}

  /// Reads the output that has arrived, and passes each line to `line`. Does not wait.
  void read(const Lines::Line& line);
  [[nodiscard]] const os::Fd& output() const noexcept { return output_; }
  [[nodiscard]] const os::Fd& error() const noexcept { return error_; }
  /// Returns the last kept line that is not empty; empty if there is none.
  [[nodiscard]] std::string last_words() const;

 private:
  void read(os::Fd& fd, Lines& lines, const Lines::Line& line);

  os::Fd output_;
  os::Fd error_;
  Lines output_lines_;
  Lines error_lines_;
  std::deque<std::string> kept_;
};

}  // namespace takt::node
