#include "watch/line.hpp"

#include <algorithm>

#include <fmt/format.h>

#include <takt/core/words.hpp>

namespace takt::tool::watch {

namespace {

constexpr std::string_view code_of(Ink ink) {
  switch (ink) {
    case Ink::plain:
      return "";
    case Ink::good:
      return "32";
    case Ink::warning:
      return "33";
    case Ink::bad:
      return "31";
    case Ink::dim:
      return "2";
    case Ink::title:
      return "1";
  }
  return "";
}

std::size_t length_of_first(std::string_view text) { return std::max<std::size_t>(utf8_length(text), 1); }

std::string_view first(std::string_view text, std::size_t columns) {
  std::size_t at = 0;
  for (; at < text.size() && columns > 0; --columns) at += length_of_first(text.substr(at));
  return text.substr(0, at);
}

std::string without_unicode(std::string_view text) {
  std::string ascii;
  for (std::size_t at = 0; at < text.size(); at += length_of_first(text.substr(at)))
    ascii += static_cast<unsigned char>(text[at]) < 0x80 ? text[at] : '?';
  return ascii;
}

}  // namespace

std::size_t columns_of(std::string_view text) {
  std::size_t columns = 0;
  for (std::size_t at = 0; at < text.size(); ++columns) at += length_of_first(text.substr(at));
  return columns;
}

std::vector<std::string> wrapped(const std::string& text, std::size_t room) {
  std::vector<std::string> lines;
  std::string rest = text;
  do {
    std::size_t end = rest.size();
    if (columns_of(rest) > room) {
      end = 0;
      for (std::size_t at = rest.find(' '); at != std::string::npos; at = rest.find(' ', at + 1)) {
        if (columns_of(rest.substr(0, at)) > room) break;
        end = at;
      }
      if (end == 0) end = first(rest, std::max<std::size_t>(room, 1)).size();
    }
    lines.push_back(rest.substr(0, end));
    rest.erase(0, rest[end] == ' ' ? end + 1 : end);
  } while (!rest.empty());
  return lines;
}

std::string in_us(double us) {
  return us < 10     ? fmt::format("{:.2f}", us)
         : us < 1000 ? fmt::format("{:.1f}", us)
                     : fmt::format("{:.0f}", us);
}

Line& Line::add(std::string_view text, Ink ink) {
  pieces_.push_back({on_one_line(text), ink});
  width_ += columns_of(pieces_.back().text);
  return *this;
}

Line& Line::add(const Line& other) {
  pieces_.insert(pieces_.end(), other.pieces_.begin(), other.pieces_.end());
  width_ += other.width_;
  return *this;
}

Line& Line::left(std::string_view text, std::size_t columns, Ink ink) {
  const std::size_t before = width_;
  add(text, ink);
  Piece& piece = pieces_.back();
  const std::size_t taken = width_ - before;
  if (taken > columns) {
    piece.text = first(piece.text, columns == 0 ? 0 : columns - 1);
    piece.cut = columns > 0;
  }
  width_ = before + std::min(taken, columns);
  return gap(before + columns - width_);
}

Line& Line::right(std::string_view text, std::size_t columns, Ink ink) {
  const std::size_t taken = columns_of(on_one_line(text));
  gap(taken < columns ? columns - taken : 0);
  return left(text, std::min(taken, columns), ink);
}

Line& Line::count(std::uint64_t number, std::size_t columns, Ink ink) {
  std::string text = std::to_string(number);
  for (const char unit : {'k', 'M', 'G', 'T', 'P', 'E'}) {
    if (text.size() <= columns) break;
    number /= 1000;
    text = std::to_string(number) + unit;
  }
  return right(text, columns, ink);
}

Line& Line::gap(std::size_t columns) {
  if (columns > 0) pieces_.push_back({std::string(columns, ' '), Ink::plain});
  width_ += columns;
  return *this;
}

Line& Line::chosen() {
  chosen_ = true;
  return *this;
}

std::string Line::shown(std::size_t columns, ScreenStyle style) const {
  const std::string cut = style.unicode ? "…" : "~";
  const bool too_long = width_ > columns;
  std::string line;
  std::size_t room = too_long && columns > 0 ? columns - 1 : columns;
  for (const Piece& piece : pieces_) {
    std::string text = style.unicode ? piece.text : without_unicode(piece.text);
    if (piece.cut) text += cut;
    const std::string_view fits = first(text, room);
    room -= columns_of(fits);
    std::string code{code_of(piece.ink)};
    if (chosen_) code += code.empty() ? "1" : ";1";
    if (style.colour && !code.empty() && !fits.empty())
      line += "\033[" + code + "m" + std::string{fits} + "\033[0m";
    else
      line += fits;
    if (room == 0) break;
  }
  if (too_long && columns > 0) return line + cut;
  if (!style.colour) line.resize(line.find_last_not_of(' ') + 1);
  return line;
}

}  // namespace takt::tool::watch
