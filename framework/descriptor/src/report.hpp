// Gathers the problems of one descriptor and of what was put into it.
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
  /// What the texts refer to must outlive it; insertions may be added.
  explicit Report(model::Texts texts) : texts_(texts) {}

  /// Both texts in the words of core/words.hpp, so that nothing of the file breaks the line. Ignored when
  /// full.
  void add(model::Line line, std::string what, std::string fix);
  /// What model::validate found.
  void add(model::Findings& findings);

  /// No more problems are told; a reader need not look for them.
  [[nodiscard]] bool full() const;
  [[nodiscard]] bool empty() const { return problems_.empty(); }
  /// "on line 12": where something else stands, for the fix of a problem.
  [[nodiscard]] std::string whereabouts(model::Line line) const { return model::whereabouts(texts_, line); }

  /// "axes.xml:12"
  [[nodiscard]] std::string place(model::Line line) const { return model::place(texts_, line); }

  /// By line, first of the descriptor, then of what was put into it; problems of one line as they were added.
  /// One that several uses of a template have in common is told once. Leaves the report empty.
  Problems take();

 private:
  model::Texts texts_;
  std::vector<std::pair<model::Line, Problem>> problems_;
};

}  // namespace takt::descriptor
