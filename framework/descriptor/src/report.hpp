// Collects the problems of one descriptor, its included files and its templates.
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
  /// The file and the insertions in `texts` must outlive this object; insertions may be added later.
  explicit Report(model::Texts texts) : texts_(texts) {}

  /// Adds a problem. Both texts must quote input with the functions of core/words.hpp, so that a message
  /// stays on one line. Does nothing when full.
  void add(model::Line line, std::string what, std::string fix);
  /// Adds the problems that model::validate() found.
  void add(model::Findings& findings);

  /// True when no more problems are accepted; readers then stop looking for them.
  [[nodiscard]] bool full() const;
  [[nodiscard]] bool empty() const { return problems_.empty(); }
  /// "on line 12": the place of another element, for the fix of a problem.
  [[nodiscard]] std::string whereabouts(model::Line line) const { return model::whereabouts(texts_, line); }

  /// "axes.xml:12"
  [[nodiscard]] std::string place(model::Line line) const { return model::place(texts_, line); }

  /// The problems sorted by line: first those of the descriptor, then those of its insertions. Problems of
  /// one line keep their order. A problem that several uses of a template share is reported once. Leaves the
  /// report empty.
  Problems take();

 private:
  model::Texts texts_;
  std::vector<std::pair<model::Line, Problem>> problems_;
};

}  // namespace takt::descriptor
