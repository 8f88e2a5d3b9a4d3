#include "reports/check_report.hpp"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include <takt/core/check.hpp>
#include <takt/model/validate.hpp>
#include <takt/schedule/levels.hpp>

#include "reports/connections_report.hpp"
#include "reports/page.hpp"

namespace takt::tool {
namespace {

using Json = nlohmann::ordered_json;

using model::Device;
using model::Module;
using model::ModuleType;
using schedule::DevicePlan;
using schedule::ExecutorPlan;
using Words = Page::Words;

constexpr std::size_t kDetailIndent = 4;

/// The name of a module, marked if it is a process module: "vision (process)".
std::string called(const Module& module) {
  return module.type == ModuleType::process ? module.name + " (process)" : module.name;
}

Words called(const Device& device, const std::vector<std::uint32_t>& modules) {
  Words words;
  for (const auto index : modules) words.push_back(called(device.modules[index]));
  return words;
}

bool states_budget(const Device& device, const ExecutorPlan& plan) {
  return std::any_of(plan.periodic.begin(), plan.periodic.end(), [&](auto index) {
    return device.modules[index].type == ModuleType::thread && device.modules[index].budget.has_value();
  });
}

std::string percent(Nanoseconds part, Nanoseconds whole) {
  return fmt::format("{:.0f} %",
                     100.0 * static_cast<double>(part.count()) / static_cast<double>(whole.count()));
}

std::string in_words(const model::OverrunContract& contract) {
  const std::string word = model::to_text(contract.what);
  return contract.what == model::Overrun::catch_up ? fmt::format("{} {}", word, contract.limit) : word;
}

void executor_heading(Page& page, const model::Executor& executor, int priority) {
  std::string text = fmt::format("{}, priority {}{}, wakeup {}",
                                 executor.cpu ? fmt::format("cpu {}", *executor.cpu) : "any cpu", priority,
                                 executor.rate_monotonic ? " (auto)" : "", model::to_text(executor.wakeup));
  if (executor.overrun.what != model::Overrun::skip) text += ", overrun " + in_words(executor.overrun);
  if (executor.timing == model::Timing::let) text += ", timing let";
  if (executor.own_host) text += ", host own";
  page.heading(2, "executor " + executor.name, text);
}

/// The load of a row: the number of its modules, and the budgets of its thread modules.
struct RowLoad {
  std::size_t modules = 0;
  Nanoseconds budget{};
  bool complete = true;
};

RowLoad load_of(const Device& device, const ExecutorPlan& plan, const schedule::Table& table,
                std::size_t row) {
  RowLoad load;
  for (const auto task : table.row(row)) {
    const Module& module = device.modules[plan.periodic[task]];
    ++load.modules;
    if (module.type != ModuleType::thread) continue;
    if (!module.budget) {
      load.complete = false;
    } else {  // saturate, because a budget can be any 64-bit number
      load.budget = load.budget > Nanoseconds::max() - *module.budget ? Nanoseconds::max()
                                                                      : load.budget + *module.budget;
    }
  }
  return load;
}

std::string share_of(const RowLoad& load, Nanoseconds basic) {
  if (!load.complete && load.budget == Nanoseconds{}) return "-";
  return (load.complete ? "" : ">= ") + percent(load.budget, basic);
}

/// The table as it would be without the offsets that offsets="auto" has chosen. None if no offsets were
/// chosen.
std::optional<schedule::Table> unshifted(const Device& device, const ExecutorPlan& plan) {
  if (device.executors[plan.executor].offsets != model::Offsets::automatic) return std::nullopt;
  std::vector<schedule::Task> tasks;
  bool same = true;
  for (std::size_t i = 0; i < plan.periodic.size(); ++i) {
    const Module& module = device.modules[plan.periodic[i]];
    const Nanoseconds offset = module.offset.value_or(Nanoseconds{});
    same &= offset == plan.offsets[i];
    tasks.push_back({.period = *module.period, .priority = module.priority, .name = {}, .offset = offset});
  }
  if (same) return std::nullopt;
  auto table = schedule::Table::build(tasks);
  return table ? std::optional{std::move(table).value()} : std::nullopt;
}

std::string fullest(const Device& device, const ExecutorPlan& plan, const schedule::Table& table) {
  std::size_t modules = 0;
  RowLoad most;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const RowLoad load = load_of(device, plan, table, row);
    modules = std::max(modules, load.modules);
    most.budget = std::max(most.budget, load.budget);
    most.complete &= load.complete;
  }
  const std::string share = share_of(most, plan.basic_period);
  return count(modules, "module") + (share == "-" || most.budget == Nanoseconds{} ? "" : ", " + share);
}

/// Shows the effect of offsets="auto": the fullest row with and without offsets, and the shifted modules.
void flattened(Page& page, const Device& device, const ExecutorPlan& plan) {
  const auto before = unshifted(device, plan);
  if (!before) return;
  page.sentence(kDetailIndent, "offsets: the fullest row has " + fullest(device, plan, plan.table) +
                                   "; without offsets " + fullest(device, plan, *before));
  Words shifted;
  for (std::size_t i = 0; i < plan.periodic.size(); ++i) {
    if (plan.offsets[i] == Nanoseconds{}) continue;
    shifted.push_back(device.modules[plan.periodic[i]].name + " by " + to_text(plan.offsets[i]));
  }
  page.words(kDetailIndent, "shifted: ", shifted);
}

/// Lists the modules that have their own overrun policy.
void contracts(Page& page, const Device& device, const ExecutorPlan& plan) {
  Words own;
  for (const auto index : plan.periodic) {
    const Module& module = device.modules[index];
    if (module.overrun) own.push_back(module.name + " " + in_words(*module.overrun));
  }
  if (!own.empty()) page.words(kDetailIndent, "overrun: ", own);
}

/// Lists the thread modules that have a budget, each with the time after which a run of it counts as hung.
Words hang_limits(const Device& device, const ExecutorPlan& plan) {
  Words limits;
  for (const auto* modules : {&plan.periodic, &plan.sporadic}) {
    for (const auto index : *modules) {
      const Module& module = device.modules[index];
      if (module.hang || (module.budget && module.type == ModuleType::thread))
        limits.push_back(module.name + " " + to_text(model::hang_limit(module)));
    }
  }
  return limits;
}

/// Writes an executor's table like Figure 3 of the paper, with consecutive equal rows on one line.
void periodic_table(Page& page, const Device& device, const ExecutorPlan& plan) {
  const bool budgets = states_budget(device, plan);
  const auto before = unshifted(device, plan);
  const auto was = [&](std::size_t row) {
    const RowLoad load = load_of(device, plan, *before, row);
    return budgets ? share_of(load, plan.basic_period) : fmt::format("{}", load.modules);
  };
  std::vector<Words> heads{{"row", "offset"}};
  if (budgets) heads.front().emplace_back("load");
  if (before && !budgets) heads.front().emplace_back("modules");
  if (before) heads.front().emplace_back("before");
  std::vector<Words> modules;
  std::size_t row = 0;
  while (row < plan.rows() && modules.size() < kTextRows) {
    const auto due = plan.row(row);
    std::size_t end = row + 1;
    while (end < plan.rows() && plan.row(end) == due && (!before || was(end) == was(row))) ++end;
    Words head{end - row == 1 ? fmt::format("{}", row) : fmt::format("{}-{}", row, end - 1),
               to_text(plan.basic_period * static_cast<std::int64_t>(row))};
    const RowLoad load = load_of(device, plan, plan.table, row);
    if (budgets) head.push_back(share_of(load, plan.basic_period));
    if (before && !budgets) head.push_back(fmt::format("{}", load.modules));
    if (before) head.push_back(was(row));
    heads.push_back(std::move(head));
    modules.push_back(due.empty() ? Words{"-"} : called(device, due));
    row = end;
  }

  const auto widths = Page::widths_of(heads);
  for (std::size_t i = 0; i < heads.size(); ++i) {
    std::string lead;
    for (std::size_t column = 0; column < widths.size(); ++column) {
      lead += fmt::format("{:<{}}  ", heads[i][column], widths[column]);
    }
    if (i == 0) {
      page.dim(kDetailIndent, lead + "modules, in the order in which they run");
    } else {
      page.words(kDetailIndent, lead, modules[i - 1]);
    }
  }
  if (row < plan.rows()) {
    page.line(kDetailIndent,
              fmt::format("... and {} more; --json lists them all", count(plan.rows() - row, "row")));
  }
}

/// Writes the sporadic modules like Figure 4 of the paper, with additional columns for settings that at least
/// one module has.
void sporadic_table(Page& page, const Device& device, const ExecutorPlan& plan) {
  const auto some = [&](auto holds) {
    return std::any_of(plan.sporadic.begin(), plan.sporadic.end(),
                       [&](auto index) { return holds(device.modules[index]); });
  };
  const bool immediate = some([](const Module& m) { return m.dispatch == model::Dispatch::immediate; });
  const bool bounded = some([](const Module& m) { return m.interarrival.has_value(); });
  const bool misses = some([](const Module& m) { return m.miss == model::Miss::error; });
  std::vector<Words> rows{{"sporadic", "type", "deadline", "priority", "budget"}};
  if (immediate) rows.front().emplace_back("dispatch");
  if (bounded) rows.front().emplace_back("interarrival");
  if (misses) rows.front().emplace_back("when missed");
  Words hasty;
  for (const auto index : plan.sporadic) {
    const Module& module = device.modules[index];
    const bool checked_in_rows = module.dispatch == model::Dispatch::row;
    if (checked_in_rows && *module.deadline < plan.basic_period) hasty.push_back(module.name);
    if (rows.size() > kTextRows) continue;
    Words row{module.name, model::to_text(module.type), to_text(*module.deadline),
              fmt::format("{}", module.priority), module.budget ? to_text(*module.budget) : "-"};
    if (immediate) row.emplace_back(model::to_text(module.dispatch));
    if (bounded) row.push_back(module.interarrival ? to_text(*module.interarrival) : "-");
    if (misses) row.emplace_back(model::to_text(module.miss));
    rows.push_back(std::move(row));
  }
  page.table(kDetailIndent, rows);
  if (plan.sporadic.size() > kTextRows) {
    page.line(kDetailIndent,
              fmt::format("... and {} more; --json lists them all", plan.sporadic.size() - kTextRows));
  }
  if (!hasty.empty()) {
    page.line(kDetailIndent, page.warning("may miss deadlines, because conditions are checked only every " +
                                          to_text(plan.basic_period) + ":"));
    page.words(kDetailIndent + 2, "", hasty);
  }
}

/// Writes the SCHED_FIFO priorities of the executor's threads and programs, highest first. An executor with
/// only periodic thread modules has one thread, whose priority is in the heading.
void levels(Page& page, const Device& device, const ExecutorPlan& plan) {
  std::map<int, Words, std::greater<>> all;
  all[plan.priority].emplace_back("rows");
  std::vector<std::uint32_t> periodic = plan.periodic;
  std::stable_sort(periodic.begin(), periodic.end(),
                   [&](auto a, auto b) { return device.modules[a].priority < device.modules[b].priority; });
  for (const auto* modules : {&std::as_const(periodic), &plan.sporadic}) {
    for (const auto index : *modules) {
      const Module& module = device.modules[index];
      if (module.type == ModuleType::process)
        all[schedule::program_level(device, plan, index)].push_back(called(module));
    }
  }
  const bool has_thread = std::any_of(plan.sporadic.begin(), plan.sporadic.end(), [&](auto index) {
    return device.modules[index].type == ModuleType::thread;
  });
  if (has_thread) all[schedule::sporadic_level(plan.priority)].emplace_back("sporadic thread modules");
  if (all.size() == 1) return;
  page.blank();
  page.dim(kDetailIndent, "SCHED_FIFO  threads and process modules");
  for (const auto& [level, names] : all) page.words(kDetailIndent, fmt::format("{:<10}  ", level), names);
}

double ratio(Nanoseconds part, Nanoseconds whole) {
  return static_cast<double>(part.count()) / static_cast<double>(whole.count());
}

/// The minimum time between two releases, or none if there is no bound. A module with dispatch "row" is
/// released at most once per row, so its interarrival time is rounded up to whole rows.
std::optional<Nanoseconds> least_spacing(const Module& module, const ExecutorPlan& plan) {
  if (module.dispatch == model::Dispatch::immediate) return module.interarrival;
  const Nanoseconds basic = plan.basic_period;
  if (!module.interarrival || *module.interarrival <= basic) return basic;
  const std::int64_t rest = *module.interarrival % basic == Nanoseconds{} ? 0 : 1;
  const std::int64_t rows = *module.interarrival / basic + rest;
  // Saturate if the product exceeds 64 bits.
  return rows > Nanoseconds::max() / basic ? Nanoseconds::max() : basic * rows;
}

/// The share of the CPU's time that the budgets of the periodic thread modules take, and the modules without
/// a budget.
struct Share {
  double value = 0;
  Words unknown;
};

Share periodic_share(const Device& device, const ExecutorPlan& plan) {
  Share share;
  for (const auto index : plan.periodic) {
    const Module& module = device.modules[index];
    if (module.type != ModuleType::thread) continue;
    if (module.budget) {
      share.value += ratio(*module.budget, *module.period);
    } else {
      share.unknown.push_back(module.name);
    }
  }
  return share;
}

void predicted_load(Page& page, const Device& device, const ExecutorPlan& plan) {
  const Share share = periodic_share(device, plan);
  if (!states_budget(device, plan) && share.unknown.empty()) return;  // all modules are process modules
  page.blank();
  if (states_budget(device, plan)) {
    std::size_t fullest = 0;
    Nanoseconds most{};
    for (std::size_t row = 0; row < plan.rows(); ++row) {
      const Nanoseconds budget = plan.load(device, row).budget;
      if (budget > most) fullest = row;
      most = std::max(most, budget);
    }
    page.sentence(
        kDetailIndent,
        fmt::format(
            "predicted load{}: row {} is the fullest with {} of {} ({}); {:.1f} % of the macro period",
            share.unknown.empty() ? "" : ", at least", fullest, to_text(most), to_text(plan.basic_period),
            percent(most, plan.basic_period), 100.0 * share.value));
  }
  if (!share.unknown.empty()) {
    page.words(kDetailIndent,
               states_budget(device, plan) ? "modules without a budget: "
                                           : "load not predicted; modules without a budget: ",
               share.unknown);
  }
}

/// Writes the load of the sporadic thread modules. They run on the same CPU as the rows, with a lower
/// priority, so their load adds to the load of the rows.
void sporadic_load(Page& page, const Device& device, const ExecutorPlan& plan) {
  Words known;
  Words without_budget;
  Words without_bound;
  double most = 0;
  for (const auto index : plan.sporadic) {
    const Module& module = device.modules[index];
    if (module.type != ModuleType::thread) continue;
    const auto spacing = least_spacing(module, plan);
    if (!module.budget) {
      without_budget.push_back(module.name);
    } else if (!spacing) {
      without_bound.push_back(module.name);
    } else {
      most += ratio(*module.budget, *spacing);
      known.push_back(fmt::format("{} every {}", module.name, to_text(*spacing)));
    }
  }
  if (known.empty() && without_bound.empty()) return;  // without budgets, no load can be predicted
  page.blank();
  if (!known.empty()) {
    page.words(kDetailIndent, fmt::format("sporadic load, at most {:.4g} %: ", 100.0 * most), known);
  }
  if (!without_budget.empty())
    page.words(kDetailIndent, "sporadic modules without a budget: ", without_budget);
  if (!without_bound.empty())
    page.words(kDetailIndent, "sporadic modules, immediate, without interarrival: ", without_bound);
  const double together = most + periodic_share(device, plan).value;
  if (together > 1) {
    page.line(kDetailIndent, page.warning(fmt::format(
                                 "overload of one CPU if all events occur as often as allowed: {:.4g} %",
                                 100.0 * together)));
  }
}

void executor_text(Page& page, const Device& device, const ExecutorPlan& plan) {
  executor_heading(page, device.executors[plan.executor], plan.priority);
  if (plan.rows() == 0) {
    page.line(kDetailIndent, "no modules");
    return;
  }
  if (plan.periodic.empty()) {
    page.sentence(kDetailIndent, "basic period " + to_text(plan.basic_period) +
                                     ", half the shortest deadline, because there is no periodic module");
  } else {
    page.sentence(
        kDetailIndent,
        fmt::format("basic period {}, macro period {}, {}, {}", to_text(plan.basic_period),
                    to_text(plan.macro_period), count(plan.rows(), "row"),
                    plan.table.entries() == 1 ? "1 entry" : fmt::format("{} entries", plan.table.entries())));
    if (plan.basic_period < model::kMinPeriod) {
      page.line(
          kDetailIndent,
          page.warning("no machine can run rows this often: choose periods and offsets with a larger common "
                       "divisor"));
    }
    flattened(page, device, plan);
    contracts(page, device, plan);
    page.blank();
    periodic_table(page, device, plan);
  }
  if (!plan.sporadic.empty()) {
    page.blank();
    sporadic_table(page, device, plan);
  }
  levels(page, device, plan);
  if (const Words limits = hang_limits(device, plan); !limits.empty()) {
    page.blank();
    page.words(kDetailIndent, "a run hangs after: ", limits);
  }
  predicted_load(page, device, plan);
  sporadic_load(page, device, plan);
}

/// Writes the worst-case response time of each module, and whether the module keeps its deadline.
void proof_text(Page& page, const Device& device, const Proof& proof, std::size_t index) {
  const auto& worst_cases = proof.devices[index];
  if (worst_cases.empty()) return;
  page.blank();
  page.sentence(
      2, fmt::format("worst-case response times, computed from {}{}, on {}:",
                     proof.of_profile ? "the profile" : "the budgets",
                     proof.factor == 1 ? "" : fmt::format(" x {}", proof.factor), count(proof.cpus, "CPU")));
  std::vector<Words> rows{{"module", "cpu", "longest run", "response", "deadline", "slack", ""}};
  for (const schedule::WorstCase& worst : worst_cases) {
    if (rows.size() > kTextRows && worst.kept()) continue;
    const bool bounded = worst.response.has_value();
    rows.push_back({called(device.modules[worst.module]), fmt::format("{}", fmt::join(worst.cpus, ",")),
                    to_text(worst.run), bounded ? to_text(*worst.response) : "-", to_text(worst.deadline),
                    bounded ? to_text(worst.deadline - *worst.response) : "-",
                    worst.kept()      ? "kept"
                    : worst.unknown() ? "NOT PROVEN"
                                      : "NOT KEPT"});
  }
  page.table(kDetailIndent, rows);
  if (rows.size() <= worst_cases.size()) {
    page.line(kDetailIndent, fmt::format("... and {} more, all kept; --json lists them all",
                                         worst_cases.size() + 1 - rows.size()));
  }
}

nlohmann::ordered_json proof_json(const Device& device, const Proof& proof, std::size_t index) {
  Json modules = Json::array();
  for (const schedule::WorstCase& worst : proof.devices[index]) {
    const bool bounded = worst.response.has_value();
    modules.push_back(
        {{"name", device.modules[worst.module].name},
         {"cpus", worst.cpus},
         {"run_ns", worst.run.count()},
         {"response_ns", bounded ? Json(worst.response->count()) : Json(nullptr)},
         {"deadline_ns", worst.deadline.count()},
         {"slack_ns", bounded ? Json((worst.deadline - *worst.response).count()) : Json(nullptr)},
         {"kept", worst.kept()}});
    if (!worst.why.empty()) modules.back()["why"] = worst.why;
  }
  return {{"processors", proof.cpus},
          {"factor", proof.factor},
          {"run_times", proof.of_profile ? "profile" : "budgets"},
          {"modules", std::move(modules)}};
}

Words names(const Device& device, const std::vector<std::uint32_t>& modules) {
  Words words;
  for (const auto index : modules) words.push_back(device.modules[index].name);
  return words;
}

void unconnected_text(Page& page, const model::Cell& cell, const model::CellPorts& ports) {
  const auto modules = model::unconnected_inputs(cell, ports);
  if (modules.empty()) return;
  page.blank();
  page.line(0, page.bold("inputs without a connection, which never get a value"));
  const std::size_t shown = std::min(modules.size(), kTextRows);
  for (std::size_t i = 0; i < shown; ++i) {
    const std::string place = whereabouts(cell.texts(), modules[i].line);
    page.words(2, modules[i].module + ", " + place + ": ", modules[i].names);
  }
  if (shown < modules.size()) page.dim(2, "and " + count(modules.size() - shown, "more module"));
}

}  // namespace

std::string check_text(const model::Cell& cell, const std::vector<DevicePlan>& plans, Style style,
                       const std::optional<Proof>& proof, const model::CellPorts& ports) {
  TAKT_CHECK(plans.size() == cell.devices.size());
  std::size_t modules = 0;
  for (const Device& device : cell.devices) modules += device.modules.size();
  Page page{style};
  page.heading(0, "cell " + cell.name,
               count(cell.devices.size(), "device") + ", " + count(modules, "module"));
  if (is_on_network(cell)) page.sentence(0, network_text(cell));
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const Device& device = cell.devices[i];
    page.blank();
    page.line(0, page.bold("device " + device.name));
    for (const ExecutorPlan& plan : plans[i].executors) {
      if (&plan != &plans[i].executors.front()) page.blank();
      executor_text(page, device, plan);
    }
    if (!plans[i].non_realtime.empty()) {
      page.blank();
      page.words(2, "not real-time: ", called(device, plans[i].non_realtime));
    }
    if (proof) proof_text(page, device, *proof, i);
  }
  connections_text(page, cell);
  unconnected_text(page, cell, ports);
  return std::move(page).take();
}

nlohmann::ordered_json check_json(const model::Cell& cell, const std::vector<DevicePlan>& plans,
                                  const std::optional<Proof>& proof) {
  TAKT_CHECK(plans.size() == cell.devices.size());
  Json devices = Json::array();
  for (std::size_t i = 0; i < plans.size(); ++i) {
    const Device& device = cell.devices[i];
    Json executors = Json::array();
    for (const ExecutorPlan& plan : plans[i].executors) {
      Json rows = Json::array();
      for (std::size_t row = 0; row < plan.rows(); ++row) rows.push_back(names(device, plan.row(row)));
      executors.push_back(Json{{"name", device.executors[plan.executor].name},
                               {"basic_period_ns", plan.basic_period.count()},
                               {"macro_period_ns", plan.macro_period.count()},
                               {"rows", std::move(rows)},
                               {"sporadic", names(device, plan.sporadic)}});
      // Add only the priorities and offsets that Takt has chosen automatically.
      if (device.executors[plan.executor].rate_monotonic) executors.back()["priority"] = plan.priority;
      for (std::size_t p = 0; p < plan.periodic.size(); ++p) {
        if (plan.offsets[p] == Nanoseconds{}) continue;
        executors.back()["offsets_ns"][device.modules[plan.periodic[p]].name] = plan.offsets[p].count();
      }
    }
    devices.push_back(Json{{"name", device.name},
                           {"executors", std::move(executors)},
                           {"non_realtime", names(device, plans[i].non_realtime)}});
    if (proof) devices.back()["worst_case"] = proof_json(device, *proof, i);
  }
  return Json{{"cell", cell.name}, {"devices", std::move(devices)}};
}

}  // namespace takt::tool
