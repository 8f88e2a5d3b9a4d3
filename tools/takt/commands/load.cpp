#include "commands/load.hpp"

#include <cstdio>

#include <takt/descriptor/descriptor.hpp>

#include "terminal/terminal.hpp"

namespace takt::tool {

Result<Loaded> load_remote(const std::string& file) {
  std::string text;
  auto cell = descriptor::load(file, &text);
  if (!cell) return cell.problems();
  auto plans = schedule::plan(*cell);
  if (!plans) return plans.problems();
  return Loaded{std::move(text), std::move(*cell), std::move(*plans), {}, {}};
}

Result<Loaded> load(const std::string& file, Problems* missing) {
  std::string text;
  model::Cell rejected;
  Problems problems;
  auto cell = descriptor::load(file, &text, &rejected);
  if (!cell) {
    if (missing == nullptr) problems = host::misnamed_files(rejected);
    problems.insert(problems.end(), cell.problems().begin(), cell.problems().end());
    return problems;
  }
  auto plans = schedule::plan(*cell);
  if (!plans) problems = plans.problems();
  auto components = host::check_components(*cell, missing);
  if (!components)
    problems.insert(problems.end(), components.problems().begin(), components.problems().end());
  if (!problems.empty()) return problems;
  return Loaded{std::move(text), std::move(*cell), std::move(*plans), std::move(components->paths),
                std::move(components->ports)};
}

void complain(const Problems& problems) {
  if (!problems.empty()) std::fprintf(stderr, "%s\n", to_text(problems).c_str());
}

void warn(const Problems& warnings) {
  for (const Problem& warning : warnings) {
    tell(warning.where + ": warning: " + warning.what + (warning.fix.empty() ? "" : "; ") + warning.fix);
  }
}

int refuse(const Problems& problems) {
  complain(problems);
  return 1;
}

}  // namespace takt::tool
