#include <takt/model/findings.hpp>

#include <algorithm>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>

namespace takt::model {

void Findings::add(int line, std::string what, std::string fix) {
  if (full()) return;
  std::string where = cell_.file.empty() && line == 0 ? "cell " + brief(cell_.name) : place(cell_.file, line);
  problems_.emplace_back(line, Problem{std::move(where), std::move(what), std::move(fix)});
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
