// A line on a terminal, made of pieces of text with colours. Colours do not count in the width.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "terminal/screen_style.hpp"

namespace takt::tool::watch {

enum class Ink { plain, good, warning, bad, dim, title };

/// The number of columns of a text; each character takes one column.
std::size_t columns_of(std::string_view text);
/// Microseconds, with fewer decimals for larger values.
std::string in_us(double us);

/// A line of the screen. Control characters and line feeds in a text are escaped, so that the text stays on
/// one line. Without Unicode, "?" replaces characters that the terminal cannot show.
class Line {
 public:
  Line& add(std::string_view text, Ink ink = Ink::plain);
  Line& add(const Line& other);
  /// Adds a text exactly `columns` wide: padded, or cut with a mark that shows it.
  Line& left(std::string_view text, std::size_t columns, Ink ink = Ink::plain);
  Line& right(std::string_view text, std::size_t columns, Ink ink = Ink::plain);
  /// Adds a right-aligned number. A number that does not fit is shown in thousands, millions and so on,
  /// rounded down: 12k, 3M.
  Line& count(std::uint64_t number, std::size_t columns, Ink ink = Ink::plain);
  Line& gap(std::size_t columns = 1);
  /// Highlights the whole line.
  Line& chosen();

  [[nodiscard]] std::size_t width() const noexcept { return width_; }
  [[nodiscard]] bool empty() const noexcept { return pieces_.empty(); }
  /// The line, at most `columns` wide. If it is cut, no character is split, and a mark shows the cut.
  [[nodiscard]] std::string shown(std::size_t columns, ScreenStyle style) const;

 private:
  struct Piece {
    std::string text;
    Ink ink;
    bool cut = false;  // the rest of its text was cut off
  };
  std::vector<Piece> pieces_;
  std::size_t width_ = 0;
  bool chosen_ = false;
};

}  // namespace takt::tool::watch
