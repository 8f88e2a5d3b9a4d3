// The place where an element of a cell was written in the source texts, for messages.
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

/// A line in one of the texts from which a cell was read: the descriptor, an included file or a template.
struct Line {
  Line(int the_number = 0, std::uint32_t the_insertion = 0)  // NOLINT(google-explicit-constructor)
      : insertion(the_insertion), number(the_number) {}

  /// 0: the line is in the descriptor itself. Otherwise the line is in Cell::insertions[insertion - 1].
  std::uint32_t insertion = 0;
  int number = 0;  ///< line number, from 1; 0 if unknown

  [[nodiscard]] bool given() const noexcept { return number > 0; }
  auto operator<=>(const Line&) const = default;
};

/// A text that is inserted into a cell: a file by an <include>, or a template by a <use>.
struct Insertion {
  std::string file;   ///< the file in which the text is written
  Line at{};          ///< the line of the <include> or <use>, in the descriptor or in an earlier insertion
  bool used = false;  ///< true for a <use>, false for an <include>
};

/// Where the lines of a cell come from: the descriptor, and the files and templates that <include> and <use>
/// inserted. The path of the descriptor is empty if the text was not read from a file.
struct Texts {
  const std::string& file;
  const std::vector<Insertion>& insertions;
};

/// Returns the file and line, for example "axes.xml:12". The result does not contain the uses and includes
/// that inserted the line.
std::string location(const Texts& texts, Line line);
/// Returns how the line came into the cell, for example "used at cell.xml:30, included at all.xml:2"; empty
/// if the line is in the descriptor itself.
std::string history(const Texts& texts, Line line);
/// Returns the line as text for a problem of another line, for example "on line 12" or "at axes.xml:12 (used
/// at cell.xml:30)".
std::string whereabouts(const Texts& texts, Line line);
/// Builds a problem for this line: `where` is location(), and history() is appended to `what`.
Problem problem_at(const Texts& texts, Line line, std::string what, std::string fix);

}  // namespace takt::model
