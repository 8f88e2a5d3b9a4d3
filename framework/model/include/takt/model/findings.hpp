// Collects the problems of one cell while its rules are checked.
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/cell.hpp>

namespace takt::model {

inline constexpr const char* kNameRule =
    "a name is a letter or _, then letters, digits, _ and -, at most 63 characters";

class Findings {
 public:
  /// The cell must outlive this object.
  explicit Findings(const Cell& cell) : cell_(cell) {}

  /// Adds a problem. Does nothing when full.
  void add(Line line, std::string what, std::string fix);
  /// True after kMaxProblems problems. Further checks would only cost time, above all the search for similar
  /// names.
  [[nodiscard]] bool full() const;
  /// The problems sorted by line. Leaves the list empty.
  Problems take();
  /// The problems with their lines, in the order in which they were found. Leaves the list empty.
  std::vector<std::pair<Line, Problem>> take_lines() { return std::exchange(problems_, {}); }
  /// "on line 12": the place of another element, for the fix of a problem.
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
