// What a program printed, line by line.
#pragma once

#include <deque>
#include <functional>
#include <string>

#include <takt/os/fd.hpp>

namespace takt::node {

/// Splits a stream into lines of bounded length. Control characters are shown as '?'.
class Lines {
 public:
  using Line = std::function<void(const std::string&)>;
  static constexpr std::size_t kLongest = 2000;

  void add(const std::string& bytes, const Line& line);
  /// The last line, if it was not ended.
  void finish(const Line& line);

 private:
  std::string partial_;
};

/// Reads a child's output and error as they come and keeps the last lines for whoever asks why it died.
class Output {
 public:
  static constexpr std::size_t kKept = 20;

  Output() = default;
  Output(os::Fd output, os::Fd error) : output_(std::move(output)), error_(std::move(error)) {}

  /// Reads what there is, without waiting.
  void read(const Lines::Line& line);
  [[nodiscard]] const os::Fd& output() const noexcept { return output_; }
  [[nodiscard]] const os::Fd& error() const noexcept { return error_; }
  /// The last line that was not empty; empty when there is none.
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
