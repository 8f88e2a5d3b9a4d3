#include "report.hpp"

#include <algorithm>
#include <map>
#include <tuple>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>

namespace takt::descriptor {

bool Report::full() const { return problems_.size() >= model::kMaxProblems; }

void Report::add(model::Line line, std::string what, std::string fix) {
  if (full()) return;
  problems_.emplace_back(line, model::problem_at(texts_, line, std::move(what), std::move(fix)));
}

void Report::add(model::Findings& findings) {
  for (auto& found : findings.take_lines()) {
    if (full()) return;
    problems_.push_back(std::move(found));
  }
}

Problems Report::take() {
  const bool was_full = full();
  std::stable_sort(problems_.begin(), problems_.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  struct Shared {
    std::size_t index;    // index in `sorted`
    std::size_t repeats;  // number of other uses of the template that cause the same problem
  };
  std::map<std::tuple<std::string, std::string, std::string>, Shared> shared;
  Problems sorted;
  for (auto& [line, problem] : problems_) {
    const std::string history = line.insertion == 0 ? "" : " (" + model::history(texts_, line) + ")";
    if (history.empty()) {
      sorted.push_back(std::move(problem));
      continue;
    }
    const bool has_history = problem.what.ends_with(history);
    std::string own = problem.what.substr(0, problem.what.size() - (has_history ? history.size() : 0));
    const auto [known, is_new] =
        shared.try_emplace({problem.where, std::move(own), problem.fix}, Shared{sorted.size(), 0});
    if (is_new)
      sorted.push_back(std::move(problem));
    else
      ++known->second.repeats;
  }
  for (const auto& [key, each] : shared) {
    std::string& what = sorted[each.index].what;
    if (each.repeats > 0 && what.ends_with(')'))
      what.insert(what.size() - 1, ", and " + std::to_string(each.repeats) + " more");
  }
  problems_.clear();
  if (was_full)
    sorted.back() = {sorted.back().where, "too many problems to list", "fix the problems above first"};
  return sorted;
}

}  // namespace takt::descriptor
