// Collects the problems of a cell during validation.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

inline constexpr const char* kNameRule =
    "a name begins with a letter or _, continues with letters, digits, _ and -, and has at most 63 "
    "characters";

class Findings {
 public:
  /// `cell` must outlive this object.
  explicit Findings(const Cell& cell) : cell_(cell) {}

  /// Adds a problem. Does nothing if full() is true.
  void add(Line line, std::string what, std::string fix);
  /// Returns true after kMaxProblems problems. The rules then stop, because further checks (above all the
  /// search for similar names) only cost time.
  [[nodiscard]] bool full() const;
  /// Returns the problems sorted by line, and empties the list.
  Problems take();
  /// Returns the problems with their lines, in the order in which they were found, and empties the list.
  std::vector<std::pair<Line, Problem>> take_lines() { return std::exchange(problems_, {}); }
  /// Returns the line of an element as text, for example "on line 12", for the fix of a problem that refers
  /// to this element.
  [[nodiscard]] std::string whereabouts(Line line) const { return model::whereabouts(cell_.texts(), line); }

 private:
  const Cell& cell_;
  std::vector<std::pair<Line, Problem>> problems_;
};

template <class Named>
std::vector<std::string_view> names_of(const std::vector<Named>& all) {
  std::vector<std::string_view> names;
  names.reserve(all.size());
  for (const Named& one : all) names.emplace_back(one.name);
  return names;
}

}  // namespace takt::model
