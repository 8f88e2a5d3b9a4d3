// The source line of a part of a cell, for messages.
//
// A line number alone is not enough. A descriptor may include files, and a template is written once but used
// many times. For a mistake in a template, the author needs both the wrong line and the use of the template.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::model {

/// A line in one of the texts from which a cell was read. A number without an insertion is a line of the
/// descriptor itself.
struct Line {
  Line(int the_number = 0, std::uint32_t the_insertion = 0)  // NOLINT(google-explicit-constructor)
      : insertion(the_insertion), number(the_number) {}

  std::uint32_t insertion = 0;  ///< 0: in the descriptor itself; else in Cell::insertions[insertion - 1]
  int number = 0;               ///< from 1; 0: no line

  [[nodiscard]] bool given() const noexcept { return number > 0; }
  auto operator<=>(const Line&) const = default;
};

/// A text inserted into the cell from elsewhere: a file by an <include>, or a template by a <use>.
struct Insertion {
  std::string file;   ///< the file that contains the text
  Line at{};          ///< the element that inserts it, in the descriptor or in an earlier insertion
  bool used = false;  ///< inserted by a <use>
};

/// The texts of a cell: the descriptor and the insertions. The path of the descriptor is empty if there is
/// none.
struct Texts {
  const std::string& file;
  const std::vector<Insertion>& insertions;
};

/// "axes.xml:12", without the uses and includes that lead to the line.
std::string place(const Texts& texts, Line line);
/// The uses and includes: "used at cell.xml:30, included at all.xml:2"; empty for a line of the descriptor.
std::string history(const Texts& texts, Line line);
/// A reference within another problem: "on line 12", or "at axes.xml:12 (used at cell.xml:30)".
std::string whereabouts(const Texts& texts, Line line);
/// A problem at place(); the history is appended to `what`.
Problem problem_at(const Texts& texts, Line line, std::string what, std::string fix);

}  // namespace takt::model
