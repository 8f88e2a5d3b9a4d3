// A line of a terminal's screen, put together from pieces whose colours take no column.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "terminal/screen_style.hpp"

namespace takt::tool::watch {

enum class Ink { plain, good, warning, bad, dim, title };

/// Each character takes a column.
std::size_t columns_of(std::string_view text);
/// Microseconds, with fewer decimals the more there are.
std::string in_us(double us);

/// What others wrote is shown as one line; where the terminal has no Unicode, "?" stands for what it cannot
/// show.
class Line {
 public:
  Line& add(std::string_view text, Ink ink = Ink::plain);
  Line& add(const Line& other);
  /// Exactly `columns` wide: filled up, or cut with a sign that it was.
  Line& left(std::string_view text, std::size_t columns, Ink ink = Ink::plain);
  Line& right(std::string_view text, std::size_t columns, Ink ink = Ink::plain);
  /// To the right. What has no room is told in thousands, millions and so on, rounded down: 12k, 3M.
  Line& count(std::uint64_t number, std::size_t columns, Ink ink = Ink::plain);
  Line& gap(std::size_t columns = 1);
  /// All of it stands out.
  Line& chosen();

  [[nodiscard]] std::size_t width() const noexcept { return width_; }
  [[nodiscard]] bool empty() const noexcept { return pieces_.empty(); }
  /// At most `columns` wide, no character cut in two, with a sign that it was cut.
  [[nodiscard]] std::string shown(std::size_t columns, ScreenStyle style) const;

 private:
  struct Piece {
    std::string text;
    Ink ink;
    bool cut = false;  // something was left out after it
  };
  std::vector<Piece> pieces_;
  std::size_t width_ = 0;
  bool chosen_ = false;
};

}  // namespace takt::tool::watch
