// Where something of a cell stands, for messages.
//
// A number is not enough: a descriptor may include files, and what a template holds stands once in a file and
// many times in the cell. Who made a mistake there wants to know both: the line that is wrong, and the use
// that made it wrong.
#pragma once

#include <compare>
#include <cstdint>
#include <string>
#include <vector>

#include <takt/core/result.hpp>

namespace takt::model {

/// A line of one of the texts that a cell was read from. A number alone is a line of the descriptor itself.
struct Line {
  Line(int the_number = 0, std::uint32_t the_insertion = 0)  // NOLINT(google-explicit-constructor)
      : insertion(the_insertion), number(the_number) {}

  std::uint32_t insertion = 0;  ///< 0: in the descriptor itself; else in Cell::insertions[insertion - 1]
  int number = 0;               ///< 0: nowhere

  [[nodiscard]] bool given() const noexcept { return number > 0; }
  auto operator<=>(const Line&) const = default;
};

/// A text that was put into the cell from elsewhere: a file by an <include>, a template by a <use>.
struct Insertion {
  std::string file;   ///< that holds the text
  Line at{};          ///< of the element that put it in; of an earlier insertion, or of the descriptor
  bool used = false;  ///< by a <use>
};

/// The texts of a cell: the descriptor's path, empty if there is none, and what was put into it.
struct Texts {
  const std::string& file;
  const std::vector<Insertion>& insertions;
};

/// "axes.xml:12", without how that line came into the cell.
std::string place(const Texts& texts, Line line);
/// "used at cell.xml:30, included at all.xml:2"; empty for a line of the descriptor itself.
std::string history(const Texts& texts, Line line);
/// For the text of another problem: "on line 12", or "at axes.xml:12 (used at cell.xml:30)".
std::string whereabouts(const Texts& texts, Line line);
/// A problem at place(); `what` is followed by the history.
Problem problem_at(const Texts& texts, Line line, std::string what, std::string fix);

}  // namespace takt::model
