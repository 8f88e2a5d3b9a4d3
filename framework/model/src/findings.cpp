#include <takt/model/findings.hpp>

#include <algorithm>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>

namespace takt::model {

void Findings::add(Line line, std::string what, std::string fix) {
  if (full()) return;
  Problem problem = problem_at(cell_.texts(), line, std::move(what), std::move(fix));
  if (cell_.file.empty() && !line.given()) problem.where = "cell " + brief(cell_.name);
  problems_.emplace_back(line, std::move(problem));
}

bool Findings::full() const { return problems_.size() >= kMaxProblems; }

Problems Findings::take() {
  std::stable_sort(problems_.begin(), problems_.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  Problems sorted;
  for (auto& [line, problem] : problems_) sorted.push_back(std::move(problem));
  problems_.clear();
  return sorted;
}

}  // namespace takt::model
