// Builds a text report: lines, headings, lists and tables that keep to the width.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "reports/style.hpp"

namespace takt::tool {

/// "1 row", "2 rows".
std::string count(std::size_t number, std::string_view noun);

/// The text of a report. Aligns columns, highlights words, and wraps lists, sentences and headings to the
/// width. In a table that is too wide, the other columns go below the first column.
class Page {
 public:
  using Words = std::vector<std::string>;

  explicit Page(Style style);

  void line(std::size_t indent, std::string_view text);
  void dim(std::size_t indent, std::string_view text);
  /// "TITLE: rest"; if it does not fit on one line, the rest goes below the title.
  void heading(std::size_t indent, const std::string& title, const std::string& rest);
  void blank() { text_ += '\n'; }

  [[nodiscard]] std::string bold(std::string_view text) const { return in_colour("1", text); }
  [[nodiscard]] std::string warning(std::string_view text) const { return in_colour("33", text); }

  /// `lead`, then the words, separated by commas and wrapped; further lines begin under the first word. A
  /// lead that leaves no room for the longest word gets its own line. Of a longer list, only the first kNamed
  /// words are shown.
  void words(std::size_t indent, std::string_view lead, Words words);
  static constexpr std::size_t kNamed = 32;

  /// A sentence, wrapped between words. A word longer than a line is broken after a dot or slash.
  void sentence(std::size_t indent, std::string_view text);

  /// The first row is the heading. All rows have the same number of cells.
  void table(std::size_t indent, const std::vector<Words>& rows);
  /// Whether table() can show each row on one line.
  [[nodiscard]] bool fits(std::size_t indent, const std::vector<Words>& rows) const;
  static std::vector<std::size_t> widths_of(const std::vector<Words>& rows);

  [[nodiscard]] std::string take() && { return std::move(text_); }

 private:
  void put(std::string line, bool dim = false);
  [[nodiscard]] std::string in_colour(std::string_view code, std::string_view text) const;

  bool colour_;
  std::size_t width_;
  std::string text_;
};

}  // namespace takt::tool
