// Builds a text report from lines, headings, lists and tables, within a maximum width.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <takt/wire/judgement.hpp>

#include "reports/style.hpp"

namespace takt::tool {

/// A number with its noun: "1 row", "2 rows".
std::string count(std::size_t number, std::string_view noun);

/// The mark before a text that reports trouble, also where there are no colours: "! " for a warning, "X " for
/// an error, and nothing otherwise.
constexpr const char* mark_of(wire::Rating rating) noexcept {
  return rating == wire::Rating::good ? "" : rating == wire::Rating::poor ? "! " : "X ";
}

/// The text of a report. Aligns columns, highlights words, and wraps lists, sentences and headings to the
/// report's width. A sentence or a cell of a table that begins with a mark has the colour of the mark. If a
/// table is too wide, its other columns go below the first column.
class Page {
 public:
  using Words = std::vector<std::string>;

  explicit Page(Style style);

  void line(std::size_t indent, std::string_view text);
  void dim(std::size_t indent, std::string_view text);
  /// Adds the line "TITLE: rest". If the line is too long, the rest goes below the title.
  void heading(std::size_t indent, const std::string& title, const std::string& rest);
  void blank() { text_ += '\n'; }

  [[nodiscard]] std::string bold(std::string_view text) const { return in_colour("1", text); }
  [[nodiscard]] std::string warning(std::string_view text) const { return in_colour("33", text); }

  /// Adds `lead`, followed by the words, which are separated by commas and wrapped. Further lines begin under
  /// the first word. If the lead leaves too little width for the longest word, the lead gets its own line.
  /// Only the first kNamed words are shown; a note counts the rest.
  void words(std::size_t indent, std::string_view lead, Words words);
  static constexpr std::size_t kNamed = 32;

  /// Adds a sentence, wrapped between words. A word that is longer than a line is broken after a dot or
  /// slash.
  void sentence(std::size_t indent, std::string_view text);

  /// Adds a table. The first row is the heading. All rows have the same number of cells.
  void table(std::size_t indent, const std::vector<Words>& rows);
  /// True if table() can show each row on one line within the width.
  [[nodiscard]] bool fits(std::size_t indent, const std::vector<Words>& rows) const;
  static std::vector<std::size_t> widths_of(const std::vector<Words>& rows);

  [[nodiscard]] std::string take() && { return std::move(text_); }

 private:
  void put(std::string line, std::string_view code = {});
  /// The code of the colour of a text with a mark; empty if the text has no mark.
  static std::string_view code_of(std::string_view text) noexcept;
  [[nodiscard]] std::string in_colour(std::string_view code, std::string_view text) const;

  bool colour_;
  std::size_t width_;
  std::string text_;
};

}  // namespace takt::tool
