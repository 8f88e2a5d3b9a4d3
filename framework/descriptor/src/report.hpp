// Collects the problems of a descriptor, its included files and its templates.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <takt/core/result.hpp>
#include <takt/model/findings.hpp>
#include <takt/model/line.hpp>

namespace takt::descriptor {

class Report {
 public:
  /// The file and the insertions to which `texts` refers must outlive this object; insertions may be added
  /// later.
  explicit Report(model::Texts texts) : texts_(texts) {}

  /// Adds a problem. Does nothing if full() is true. Both texts must quote any part of the descriptor with
  /// the functions of core/words.hpp, so that a message stays on one line.
  void add(model::Line line, std::string what, std::string fix);
  /// Adds the problems that model::validate() has found.
  void add(model::Findings& findings);

  /// Returns true if no more problems are accepted. Readers then stop looking for problems.
  [[nodiscard]] bool full() const;
  [[nodiscard]] bool empty() const { return problems_.empty(); }
  /// The line of another element as text, for example "on line 12", for use in the fix of a problem.
  [[nodiscard]] std::string whereabouts(model::Line line) const { return model::whereabouts(texts_, line); }

  /// The file and line as text, for example "axes.xml:12".
  [[nodiscard]] std::string place(model::Line line) const { return model::place(texts_, line); }

  /// Returns the problems sorted by line: first those of the descriptor, then those of its insertions.
  /// Problems of the same line keep their order. If several uses of a template cause the same problem, it is
  /// reported only once. Empties the report.
  Problems take();

 private:
  model::Texts texts_;
  std::vector<std::pair<model::Line, Problem>> problems_;
};

}  // namespace takt::descriptor
