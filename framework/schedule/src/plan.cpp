#include <takt/schedule/plan.hpp>

#include <algorithm>
#include <iterator>
#include <numeric>
#include <set>
#include <string>
#include <utility>

#include "offsets.hpp"

namespace takt::schedule {
namespace {

using model::Device;
using model::Module;
using model::ModuleType;
using model::Operation;

/// The maximum number of modules that an error message about a full row lists.
constexpr std::size_t kNamedModules = 12;

Problem problem_of(const model::Cell& cell, const Module& module, std::string what, std::string fix,
                   model::Line element = {}) {
  Problem problem = model::problem_at(cell.texts(), element.given() ? element : module.line, std::move(what),
                                      std::move(fix));
  if (cell.file.empty()) problem.where = "module " + module.name;
  return problem;
}

/// A 128-bit integer, because sums of int64 budgets need more than 64 bits.
__extension__ using Wide = __int128;
constexpr Wide kLargestBudget = Nanoseconds::max().count();

struct WideLoad {
  Wide budget = 0;
  bool complete = true;
};

WideLoad load_of(const Device& device, const ExecutorPlan& plan, std::size_t row) {
  WideLoad load;
  if (plan.periodic.empty()) return load;
  for (const auto task : plan.table.row(row)) {
    const Module& module = device.modules[plan.periodic[task]];
    if (module.type != ModuleType::thread) continue;
    if (module.budget) {
      load.budget += module.budget->count();
    } else {
      load.complete = false;
    }
  }
  return load;
}

void sort_by_priority(const Device& device, std::vector<std::uint32_t>& modules) {
  std::stable_sort(modules.begin(), modules.end(),
                   [&](auto a, auto b) { return device.modules[a].priority < device.modules[b].priority; });
}

void check_own_budgets(const model::Cell& cell, const Device& device, Problems& problems) {
  for (const Module& module : device.modules) {
    if (!module.budget) continue;
    const bool sporadic = module.operation == Operation::sporadic;
    if (sporadic && module.interarrival && *module.interarrival < *module.budget) {
      const std::string budget = to_text(*module.budget);
      problems.push_back(problem_of(cell, module,
                                    "the interarrival time of '" + module.name + "', " +
                                        to_text(*module.interarrival) + ", is shorter than its budget, " +
                                        budget,
                                    "lengthen the <interarrival> to at least " + budget +
                                        ", or reduce the budget: a run must end before the next release",
                                    module.lines.interarrival));
    }
    const auto& bound = sporadic ? module.deadline : module.period;
    if (!bound || *module.budget <= *bound) continue;
    const std::string word = sporadic ? "deadline" : "period";
    problems.push_back(
        problem_of(cell, module,
                   "the budget of '" + module.name + "', " + to_text(*module.budget) +
                       ", is larger than its " + word + ", " + to_text(*bound),
                   "reduce the budget to at most " + to_text(*bound) + ", or lengthen the " + word));
  }
}

/// The module whose given offset is not a multiple of `period`, and shortens the basic period most; null if
/// there is none.
const Module* shortens(const Device& device, const ExecutorPlan& plan, Nanoseconds period) {
  const Module* found = nullptr;
  std::int64_t shortest = period.count();
  for (const auto index : plan.periodic) {
    const Module& module = device.modules[index];
    const std::int64_t basic = std::gcd(period.count(), module.offset.value_or(Nanoseconds{0}).count());
    if (basic >= shortest) continue;
    shortest = basic;
    found = &module;
  }
  return found;
}

void check_rows(const model::Cell& cell, const Device& device, const ExecutorPlan& plan, Problems& problems) {
  std::size_t fullest = 0;
  std::size_t too_full = 0;
  Wide most = 0;
  for (std::size_t row = 0; row < plan.rows(); ++row) {
    const Wide budget = load_of(device, plan, row).budget;
    if (budget > plan.basic_period.count()) ++too_full;
    if (budget <= most) continue;
    most = budget;
    fullest = row;
  }
  if (too_full == 0) return;

  std::vector<std::uint32_t> named = plan.row(fullest);
  std::erase_if(named, [&](auto index) {
    return device.modules[index].type != ModuleType::thread || !device.modules[index].budget;
  });
  const auto largest = *std::max_element(named.begin(), named.end(), [&](auto a, auto b) {
    return *device.modules[a].budget < *device.modules[b].budget;
  });
  std::string list;
  for (std::size_t i = 0; i < std::min(named.size(), kNamedModules); ++i) {
    const Module& module = device.modules[named[i]];
    list += (i == 0 ? "" : ", ") + module.name + " " + to_text(*module.budget);
  }
  if (named.size() > kNamedModules) list += " and " + std::to_string(named.size() - kNamedModules) + " more";

  Nanoseconds by_periods{0};  // the basic period that the table would have without offsets
  for (const auto index : plan.periodic)
    by_periods = Nanoseconds{std::gcd(by_periods.count(), device.modules[index].period->count())};
  const Module* offset = most <= by_periods.count() ? shortens(device, plan, by_periods) : nullptr;
  if (offset != nullptr) {
    problems.push_back(problem_of(
        cell, *offset,
        "the offset of '" + offset->name + "', " + to_text(*offset->offset) +
            ", shortens the basic period of executor '" + device.executors[plan.executor].name + "' from " +
            to_text(by_periods) + " to " + to_text(plan.basic_period) +
            ", which is too short for the budget" + (named.size() == 1 ? "" : "s") + " of row " +
            std::to_string(fullest) + ": " + list,
        "choose an offset that is a multiple of " + to_text(by_periods) + ", or reduce the budgets",
        offset->lines.offset));
    return;
  }
  const std::string sum =
      most > kLargestBudget ? "more than 10^18 ns" : to_text(Nanoseconds{static_cast<std::int64_t>(most)});
  problems.push_back(problem_of(
      cell, device.modules[largest],
      "the budgets of row " + std::to_string(fullest) + " of executor '" +
          device.executors[plan.executor].name + "' exceed its basic period: " + list + " add up to " + sum +
          ", but the basic period is " + to_text(plan.basic_period) + "; " + std::to_string(too_full) +
          " of " + std::to_string(plan.rows()) + (plan.rows() == 1 ? " row is" : " rows are") + " too full",
      "reduce the budgets, lengthen the periods, or move modules to another executor"));
}

/// Chooses the offsets that the descriptor does not give. If all thread modules have a budget, balances the
/// budgets of the rows; then a process module counts as almost no load. Otherwise balances the number of
/// modules per row.
std::vector<Nanoseconds> offsets_of(const Device& device, const ExecutorPlan& plan) {
  constexpr Nanoseconds kHeaviest{std::int64_t{1} << 40};
  std::vector<Nanoseconds> given;
  std::vector<Shiftable> modules;
  bool all_budgets = true;
  for (const auto index : plan.periodic) {
    const Module& module = device.modules[index];
    given.push_back(module.offset.value_or(Nanoseconds{0}));
    modules.push_back({.period = *module.period, .offset = given.back(), .fixed = module.offset.has_value()});
    all_budgets &= module.type != ModuleType::thread || module.budget.has_value();
  }
  if (device.executors[plan.executor].offsets == model::Offsets::given) return given;
  for (std::size_t i = 0; all_budgets && i < modules.size(); ++i) {
    const Module& module = device.modules[plan.periodic[i]];
    if (module.type == ModuleType::thread) modules[i].weight = std::min(*module.budget, kHeaviest).count();
  }
  return flatten(modules);
}

/// Sets the priorities of the executors with priority="auto". A shorter basic period gives a higher priority.
void assign_priorities(const Device& device, std::vector<ExecutorPlan>& plans) {
  constexpr int kStep = 10;
  std::set<Nanoseconds> periods;
  for (ExecutorPlan& plan : plans) {
    plan.priority = device.executors[plan.executor].priority;
    if (device.executors[plan.executor].rate_monotonic) periods.insert(plan.basic_period);
  }
  for (ExecutorPlan& plan : plans) {
    if (!device.executors[plan.executor].rate_monotonic) continue;
    const auto step = static_cast<int>(std::distance(periods.begin(), periods.find(plan.basic_period)));
    plan.priority = std::max(kHighestAuto - kStep * step, kStep);
  }
}

/// Builds the table of an executor, and sets the periods in `plan`. The executor's modules must already be in
/// the plan.
void build_table(const model::Cell& cell, const Device& device, ExecutorPlan& plan, Problems& problems) {
  if (plan.periodic.empty()) {
    if (plan.sporadic.empty()) return;
    Nanoseconds shortest = Nanoseconds::max();
    for (const auto index : plan.sporadic) shortest = std::min(shortest, *device.modules[index].deadline);
    plan.basic_period = std::max(shortest / 2, Nanoseconds{1});
    plan.macro_period = plan.basic_period;
    return;
  }

  std::vector<Task> tasks;
  tasks.reserve(plan.periodic.size());
  plan.offsets = offsets_of(device, plan);
  for (std::size_t i = 0; i < plan.periodic.size(); ++i) {
    const Module& module = device.modules[plan.periodic[i]];
    tasks.push_back({.period = *module.period,
                     .priority = module.priority,
                     .name = module.name,
                     .offset = plan.offsets[i]});
  }
  auto table = Table::build(tasks);
  if (!table) {
    const PeriodPair pair = longest_pair(tasks);
    const Module& module = device.modules[plan.periodic[std::max(pair.shorter, pair.longer)]];
    for (const Problem& problem : table.problems()) {
      problems.push_back(
          problem_of(cell, module, "executor '" + device.executors[plan.executor].name + "': " + problem.what,
                     problem.fix));
    }
    return;
  }
  plan.table = std::move(table).value();
  plan.basic_period = plan.table.basic_period();
  plan.macro_period = plan.table.macro_period();
  check_rows(cell, device, plan, problems);
}

}  // namespace

std::size_t ExecutorPlan::rows() const noexcept {
  return periodic.empty() && !sporadic.empty() ? 1 : table.rows();
}

std::vector<std::uint32_t> ExecutorPlan::row(std::size_t row) const {
  TAKT_CHECK(row < rows());
  std::vector<std::uint32_t> modules;
  if (periodic.empty()) return modules;
  const auto tasks = table.row(row);
  modules.reserve(tasks.size());
  for (const auto task : tasks) modules.push_back(periodic[task]);
  return modules;
}

ExecutorPlan::Load ExecutorPlan::load(const Device& device, std::size_t row) const {
  TAKT_CHECK(row < rows());
  const WideLoad load = load_of(device, *this, row);
  return {.budget = Nanoseconds{static_cast<std::int64_t>(std::min(load.budget, kLargestBudget))},
          .complete = load.complete};
}

Nanoseconds offset_of(const ExecutorPlan& plan, std::uint32_t module) {
  const auto found = std::find(plan.periodic.begin(), plan.periodic.end(), module);
  TAKT_CHECK(found != plan.periodic.end());
  return plan.offsets[static_cast<std::size_t>(found - plan.periodic.begin())];
}

Result<DevicePlan> plan(const model::Cell& cell, const Device& device) {
  DevicePlan plan;
  plan.executors.resize(device.executors.size());
  for (std::uint32_t i = 0; i < plan.executors.size(); ++i) plan.executors[i].executor = i;

  for (std::uint32_t i = 0; i < device.modules.size(); ++i) {
    const Module& module = device.modules[i];
    if (module.operation == Operation::non_real) {
      plan.non_realtime.push_back(i);
      continue;
    }
    const auto executor =
        std::find_if(device.executors.begin(), device.executors.end(),
                     [&](const model::Executor& candidate) { return candidate.name == module.executor; });
    TAKT_CHECK(executor != device.executors.end());
    ExecutorPlan& own = plan.executors[static_cast<std::size_t>(executor - device.executors.begin())];
    if (module.operation == Operation::periodic) {
      TAKT_CHECK(module.period && module.period->count() > 0);
      own.periodic.push_back(i);
    } else {
      TAKT_CHECK(module.deadline && module.deadline->count() > 0);
      own.sporadic.push_back(i);
    }
  }

  Problems problems;
  check_own_budgets(cell, device, problems);
  sort_by_priority(device, plan.non_realtime);
  for (ExecutorPlan& executor : plan.executors) {
    sort_by_priority(device, executor.sporadic);
    build_table(cell, device, executor, problems);
  }
  assign_priorities(device, plan.executors);
  if (!problems.empty()) return problems;
  return plan;
}

Result<std::vector<DevicePlan>> plan(const model::Cell& cell) {
  std::vector<DevicePlan> plans;
  Problems problems;
  for (const Device& device : cell.devices) {
    auto planned = plan(cell, device);
    if (planned) {
      plans.push_back(std::move(planned).value());
    } else {
      problems.insert(problems.end(), planned.problems().begin(), planned.problems().end());
    }
  }
  if (!problems.empty()) return problems;
  return plans;
}

}  // namespace takt::schedule
