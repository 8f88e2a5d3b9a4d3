// A line on a terminal, made of pieces of coloured text. Colour codes do not count in the line's width.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "terminal/screen_style.hpp"

namespace takt::tool::watch {

enum class Ink { plain, good, warning, bad, dim, title };

/// The number of terminal columns that a text needs; each character takes one column.
std::size_t columns_of(std::string_view text);
/// Splits a text at spaces into lines of at most `room` columns. A longer word is broken. Returns at least
/// one line.
std::vector<std::string> wrapped(const std::string& text, std::size_t room);
/// Formats a number of microseconds, with fewer decimals for larger values.
std::string in_us(double us);

/// A line of the screen. Control characters and line feeds in its text are escaped, so that it stays one
/// line. On a terminal without Unicode, "?" replaces each character that the terminal cannot show.
class Line {
 public:
  Line& add(std::string_view text, Ink ink = Ink::plain);
  Line& add(const Line& other);
  /// Adds a text and pads it to `columns`, or cuts it to `columns` and marks the cut.
  Line& left(std::string_view text, std::size_t columns, Ink ink = Ink::plain);
  Line& right(std::string_view text, std::size_t columns, Ink ink = Ink::plain);
  /// Adds a right-aligned number. If the number does not fit, it is shown in thousands, millions and so on,
  /// rounded down: 12k, 3M.
  Line& count(std::uint64_t number, std::size_t columns, Ink ink = Ink::plain);
  Line& gap(std::size_t columns = 1);
  /// Highlights the whole line.
  Line& chosen();

  [[nodiscard]] std::size_t width() const noexcept { return width_; }
  [[nodiscard]] bool empty() const noexcept { return pieces_.empty(); }
  /// The text of the line, cut to `columns`. A cut never splits a character, and a mark shows it.
  [[nodiscard]] std::string shown(std::size_t columns, ScreenStyle style) const;

 private:
  struct Piece {
    std::string text;
    Ink ink;
    bool cut = false;  // `text` is only the start of the text that was added
  };
  std::vector<Piece> pieces_;
  std::size_t width_ = 0;
  bool chosen_ = false;
};

}  // namespace takt::tool::watch
