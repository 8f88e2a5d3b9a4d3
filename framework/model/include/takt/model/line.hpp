// The place in the source texts where an element of a cell was written, for messages.
//
// A line number alone is not enough. A descriptor may include files, and a template is written once but may
// be used many times. For a mistake in a template, the author needs both the line of the mistake and the line
// that uses the template.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::model {

/// A line in one of the texts from which a cell was read.
struct Line {
  Line(int the_number = 0, std::uint32_t the_insertion = 0)  // NOLINT(google-explicit-constructor)
      : insertion(the_insertion), number(the_number) {}

  std::uint32_t insertion = 0;  ///< 0: the line is in the descriptor itself; otherwise it is in
                                ///< Cell::insertions[insertion - 1]
  int number = 0;               ///< line number, from 1; 0 if unknown

  [[nodiscard]] bool given() const noexcept { return number > 0; }
  auto operator<=>(const Line&) const = default;
};

/// A text that is inserted into a cell: a file by an <include>, or a template by a <use>.
struct Insertion {
  std::string file;   ///< the file in which the text is written
  Line at{};          ///< where the <include> or <use> is: in the descriptor, or in an earlier insertion
  bool used = false;  ///< true for a <use>, false for an <include>
};

/// The texts of a cell: the descriptor and its insertions. The path of the descriptor is empty if there is no
/// file.
struct Texts {
  const std::string& file;
  const std::vector<Insertion>& insertions;
};

/// The file and line, for example "axes.xml:12", without the uses and includes that led to it.
std::string place(const Texts& texts, Line line);
/// How the line came into the cell, for example "used at cell.xml:30, included at all.xml:2"; empty for a
/// line of the descriptor itself.
std::string history(const Texts& texts, Line line);
/// Refers to a line within the text of another problem, for example "on line 12" or "at axes.xml:12 (used at
/// cell.xml:30)".
std::string whereabouts(const Texts& texts, Line line);
/// Builds a problem whose `where` is place(). history() is appended to `what`.
Problem problem_at(const Texts& texts, Line line, std::string what, std::string fix);

}  // namespace takt::model
