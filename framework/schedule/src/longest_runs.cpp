#include <takt/schedule/longest_runs.hpp>

#include <algorithm>
#include <cmath>
#include <string>

#include <takt/core/words.hpp>

namespace takt::schedule {

namespace {

using model::Module;
using model::Operation;

Nanoseconds times(Nanoseconds run, double factor) {
  constexpr auto kLargest = static_cast<double>(Nanoseconds::max().count());
  const double longer = std::ceil(static_cast<double>(run.count()) * factor);
  // For factor 1, return the exact time: a double has only 53 bits and would round a long run time.
  if (factor == 1) return run;
  return longer >= kLargest ? Nanoseconds::max() : Nanoseconds{static_cast<std::int64_t>(longer)};
}

std::optional<Nanoseconds> longest(const Module& module, const std::string& path,
                                   const model::Profile* profile) {
  if (profile == nullptr) return module.budget;
  const auto measured = profile->modules.find(path);
  const bool ran = measured != profile->modules.end() && measured->second.runs > 0;
  return ran ? measured->second.max : module.budget;
}

}  // namespace

Result<LongestRuns> longest_runs(const model::Cell& cell, const model::Profile* profile, double factor) {
  TAKT_CHECK(factor >= 1);
  Problems problems;
  if (profile != nullptr && profile->cell != cell.name) {
    problems.push_back(model::problem_at(cell.texts(), cell.line,
                                         "the profile belongs to cell " + in_quotes(profile->cell) +
                                             ", but this cell is " + in_quotes(cell.name),
                                         "use a profile of this cell, written by takt run --profile"));
  }
  LongestRuns all;
  for (const model::Device& device : cell.devices) {
    auto& runs = all.emplace_back();
    for (const Module& module : device.modules) {
      auto& run = runs.emplace_back();
      if (module.operation == Operation::non_real) continue;
      run = longest(module, device.name + "." + module.name, profile);
      if (run) {
        run = times(*run, factor);
      } else {
        problems.push_back(model::problem_at(
            cell.texts(), module.line,
            "the run time of " + in_quotes(device.name + "." + module.name) + " is not known",
            "add a <budget>, or use a profile in which this module ran"));
      }
    }
  }
  if (!problems.empty()) return problems;
  return all;
}

bool all_state_budgets(const model::Cell& cell) {
  bool any = false;
  for (const model::Device& device : cell.devices) {
    for (const Module& module : device.modules) {
      if (module.operation == Operation::non_real) continue;
      if (!module.budget) return false;
      any = true;
    }
  }
  return any;
}

}  // namespace takt::schedule
