#include <takt/descriptor/report.hpp>

#include <algorithm>
#include <charconv>

#include <takt/core/words.hpp>
#include <takt/model/validate.hpp>

namespace takt::descriptor {

namespace {

/// Of "file:12" and of "line 12".
int line_of(const std::string& where) {
  const std::size_t number = where.find_last_not_of("0123456789") + 1;
  int line = 1;
  std::from_chars(where.data() + number, where.data() + where.size(), line);
  return line;
}

}  // namespace

bool Report::full() const { return problems_.size() >= model::kMaxProblems; }

void Report::add(int line, std::string what, std::string fix) {
  if (full()) return;
  problems_.emplace_back(line, Problem{place(file_, line), std::move(what), std::move(fix)});
}

void Report::add(Problems problems) {
  for (Problem& problem : problems) {
    if (full()) return;
    const int line = line_of(problem.where);
    problems_.emplace_back(line, std::move(problem));
  }
}

Problems Report::take() {
  const bool was_full = full();
  std::stable_sort(problems_.begin(), problems_.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  Problems sorted;
  for (auto& [line, problem] : problems_) sorted.push_back(std::move(problem));
  problems_.clear();
  if (was_full)
    sorted.back() = {sorted.back().where, "too many problems to name them all", "mend those above first"};
  return sorted;
}

}  // namespace takt::descriptor
