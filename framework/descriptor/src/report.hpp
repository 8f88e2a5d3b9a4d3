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
  /// The file and the insertions to which `texts` refers must outlive this object. Later, insertions may be
  /// added.
  explicit Report(model::Texts texts) : texts_(texts) {}

  /// Adds a problem. Does nothing if full() is true. Any part of the descriptor in `what` or `fix` must be
  /// quoted with the functions of core/words.hpp, so that a message stays on one line.
  void add(model::Line line, std::string what, std::string fix);
  /// Adds the problems that model::validate() has found.
  void add(model::Findings& findings);

  /// Returns true if the report accepts no more problems. Readers then stop looking for problems.
  [[nodiscard]] bool full() const;
  [[nodiscard]] bool empty() const { return problems_.empty(); }
  /// Returns the line of an element as text, for example "on line 12", for the fix of a problem that refers
  /// to this element.
  [[nodiscard]] std::string whereabouts(model::Line line) const { return model::whereabouts(texts_, line); }

  /// Returns the file and line as text, for example "axes.xml:12".
  [[nodiscard]] std::string location(model::Line line) const { return model::location(texts_, line); }

  /// Returns the problems, and empties the report. The problems are sorted by line, first those of the
  /// descriptor, then those of its insertions. Problems of the same line keep their order. A problem that
  /// several uses of a template cause is listed only once.
  Problems take();

 private:
  model::Texts texts_;
  std::vector<std::pair<model::Line, Problem>> problems_;
};

}  // namespace takt::descriptor
