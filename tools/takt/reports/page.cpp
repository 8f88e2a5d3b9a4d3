#include "reports/page.hpp"

#include <algorithm>

#include <fmt/format.h>

namespace takt::tool {

std::string count(std::size_t number, std::string_view noun) {
  return fmt::format("{} {}{}", number, noun, number == 1 ? "" : "s");
}

Page::Page(Style style) : colour_{style.colour}, width_{std::clamp<std::size_t>(style.width, 80, 100)} {}

void Page::line(std::size_t indent, std::string_view text) { put(std::string(indent, ' ').append(text)); }

void Page::dim(std::size_t indent, std::string_view text) { put(std::string(indent, ' ').append(text), "2"); }

void Page::heading(std::size_t indent, const std::string& title, const std::string& rest) {
  if (indent + title.size() + 2 + rest.size() <= width_) {
    line(indent, in_colour("1", title + ":") + " " + rest);
  } else {
    line(indent, in_colour("1", title + ":"));
    line(indent + 2, rest);
  }
}

void Page::words(std::size_t indent, std::string_view lead, Words words) {
  if (words.size() > kNamed + 1) {
    const std::size_t more = words.size() - kNamed;
    words.resize(kNamed);
    words.push_back(fmt::format("and {} more", more));
  }
  std::size_t longest = 0;
  for (const auto& word : words) longest = std::max(longest, word.size() + 1);
  std::string line(indent, ' ');
  line += lead;
  std::size_t begin = line.size();
  if (begin + longest > width_) {
    put(line);
    begin = indent + 2;
    line.assign(begin, ' ');
  }
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string word = words[i] + (i + 1 < words.size() ? "," : "");
    const std::size_t space = line.size() > begin ? 1 : 0;
    if (space == 1 && line.size() + 1 + word.size() > width_) {
      put(line);
      line.assign(begin, ' ');
    } else {
      line.append(space, ' ');
    }
    line += word;
  }
  put(line);
}

void Page::sentence(std::size_t indent, std::string_view text) {
  std::string line(indent, ' ');
  const std::string_view code = code_of(text);
  const auto end_line = [&] {
    put(line, code);
    line.assign(indent, ' ');
  };
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(' '), text.size());
    std::string_view word = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.size() > indent && line.size() + 1 + word.size() > width_) end_line();
    while (indent + word.size() > width_) {
      const std::size_t room = width_ - indent;
      const std::size_t mark = word.substr(0, room).find_last_of("./");
      const std::size_t part = mark == std::string_view::npos ? room : mark + 1;
      line += word.substr(0, part);
      word.remove_prefix(part);
      end_line();
    }
    if (line.size() > indent) line += ' ';
    line += word;
  }
  put(line, code);
}

void Page::table(std::size_t indent, const std::vector<Words>& rows) {
  const std::vector<std::size_t> widths = widths_of(rows);
  const bool below = !fits(indent, rows);
  for (const Words& row : rows) {
    const std::string_view code = &row == &rows.front() ? "2" : "";
    std::string line(indent, ' ');
    for (std::size_t i = 0; i < row.size(); ++i) {
      if (i == 1 && below) {
        put(line, code);
        line.assign(indent + 2, ' ');
      }
      line += in_colour(code_of(row[i]), row[i]);
      if (i + 1 < row.size() && !(i == 0 && below)) line.append(widths[i] - row[i].size() + 2, ' ');
    }
    put(line, code);
  }
}

bool Page::fits(std::size_t indent, const std::vector<Words>& rows) const {
  std::size_t total = indent;
  for (const std::size_t width : widths_of(rows)) total += width + 2;
  return total - 2 <= width_;
}

std::vector<std::size_t> Page::widths_of(const std::vector<Words>& rows) {
  std::vector<std::size_t> widths;
  for (const Words& row : rows) {
    widths.resize(row.size());
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  return widths;
}

void Page::put(std::string line, std::string_view code) {
  // A name in a file from elsewhere, such as a trace, must not begin a line of its own.
  for (std::size_t at = 0; (at = line.find('\n', at)) != std::string::npos;) line.replace(at, 1, "\\n");
  while (!line.empty() && line.back() == ' ') line.pop_back();
  text_ += in_colour(code, line) + "\n";
}

std::string_view Page::code_of(std::string_view text) noexcept {
  if (text.starts_with(mark_of(wire::Rating::poor))) return "33";
  return text.starts_with(mark_of(wire::Rating::bad)) ? "31" : "";
}

std::string Page::in_colour(std::string_view code, std::string_view text) const {
  return colour_ && !code.empty() ? fmt::format("\x1b[{}m{}\x1b[0m", code, text) : std::string{text};
}

}  // namespace takt::tool
