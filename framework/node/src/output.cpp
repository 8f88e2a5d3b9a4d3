#include <takt/node/output.hpp>

#include <takt/core/words.hpp>
#include <takt/os/process.hpp>

namespace takt::node {

void Lines::add(const std::string& bytes, const Line& line) {
  for (const char c : bytes) {
    if (c == '\n') {
      line(on_one_line(partial_));
      partial_.clear();
      continue;
    }
    if (partial_.size() == kLongest) {
      line(on_one_line(partial_) + " ...");
      partial_.clear();
    }
    partial_ += c == '\t' ? ' ' : c;
  }
}

void Lines::finish(const Line& line) {
  if (!partial_.empty()) line(on_one_line(partial_));
  partial_.clear();
}

void Output::read(const Lines::Line& line) {
  read(output_, output_lines_, line);
  read(error_, error_lines_, line);
}

void Output::read(os::Fd& fd, Lines& lines, const Lines::Line& line) {
  if (!fd) return;
  const auto keep = [&](const std::string& text) {
    if (kept_.size() == kKept) kept_.pop_front();
    kept_.push_back(text);
    line(text);
  };
  bool end = false;
  lines.add(os::read_available(fd, &end), keep);
  if (!end) return;
  lines.finish(keep);
  fd.close();
}

std::string Output::last_words() const {
  for (auto line = kept_.rbegin(); line != kept_.rend(); ++line) {
    if (!line->empty()) return *line;
  }
  return {};
}

}  // namespace takt::node
