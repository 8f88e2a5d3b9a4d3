// The problems of one cell while its rules are gone through.
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
  /// The cell must outlive it.
  explicit Findings(const Cell& cell) : cell_(cell) {}

  /// Ignored when full.
  void add(Line line, std::string what, std::string fix);
  /// Looking on would cost time, guesses above all, and tell nobody anything.
  [[nodiscard]] bool full() const;
  /// By line. Leaves nothing.
  Problems take();
  /// In the order in which they were found, each with its line. Leaves nothing.
  std::vector<std::pair<Line, Problem>> take_lines() { return std::exchange(problems_, {}); }
  /// "on line 12": where something else stands, for the fix of a problem.
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
