// Measures how long it takes to plan a schedule. Takt plans once for each `takt check` and each deployment,
// never on a real-time thread.
#include <array>
#include <chrono>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include <takt/schedule/plan.hpp>
#include <takt/schedule/table.hpp>

namespace takt::schedule {
namespace {

using namespace std::chrono_literals;

void build(benchmark::State& state, const std::vector<Task>& tasks) {
  std::size_t entries = 0;
  for (auto _ : state) {
    const auto table = Table::build(tasks);
    if (!table) {
      state.SkipWithError(to_text(table.problems()).c_str());
      return;
    }
    entries = table->entries();
    benchmark::DoNotOptimize(entries);
  }
  state.counters["entries"] = static_cast<double>(entries);
  state.SetItemsProcessed(static_cast<std::int64_t>(entries) * state.iterations());
}

/// Returns a thousand modules with common periods from 1 to 100 ms.
std::vector<Task> thousand_modules() {
  constexpr std::array<Nanoseconds, 6> kPeriods{1ms, 2ms, 5ms, 10ms, 20ms, 100ms};
  std::vector<Task> tasks;
  for (std::size_t i = 0; i < 1000; ++i) {
    tasks.push_back({.period = kPeriods[i % kPeriods.size()], .priority = static_cast<int>(i * 7 % 100)});
  }
  return tasks;
}

void TableOfAThousandModules(benchmark::State& state) { build(state, thousand_modules()); }
BENCHMARK(TableOfAThousandModules)->Unit(benchmark::kMillisecond);

/// Builds a table with the maximum number of entries, in a single row. The next two benchmarks build such a
/// table with a thousand rows and with a million rows.
void TableOfAMillionEntriesInOneRow(benchmark::State& state) {
  build(state, std::vector<Task>(kMaxEntries, Task{1ms, 0}));
}
BENCHMARK(TableOfAMillionEntriesInOneRow)->Unit(benchmark::kMillisecond);

void TableOfAMillionEntriesInAThousandRows(benchmark::State& state) {
  // 999 tasks are due in every row, and 1000 tasks are due once per macro period.
  std::vector<Task> tasks(999, Task{1ms, 0});
  tasks.resize(1999, Task{1s, 1});
  build(state, tasks);
}
BENCHMARK(TableOfAMillionEntriesInAThousandRows)->Unit(benchmark::kMillisecond);

void TableOfAMillionEntriesInAMillionRows(benchmark::State& state) {
  build(state, {{1us, 0}, {1us * 999'999, 0}});
}
BENCHMARK(TableOfAMillionEntriesInAMillionRows)->Unit(benchmark::kMillisecond);

/// Tries to build a table that is too long, from ten thousand different periods. The rejection must find the
/// pair of periods that makes the table too long.
void RejectionOfTenThousandPeriods(benchmark::State& state) {
  std::vector<Task> tasks;
  for (int i = 0; i < 10'000; ++i) tasks.push_back({1us * (100'000 + i), 0});
  for (auto _ : state) benchmark::DoNotOptimize(Table::build(tasks).ok());
}
BENCHMARK(RejectionOfTenThousandPeriods)->Unit(benchmark::kMillisecond);

/// Like RejectionOfTenThousandPeriods, but many pairs of periods have large common factors. So the product of
/// two periods is often much larger than their least common multiple.
void RejectionOfRoundPeriods(benchmark::State& state) {
  std::vector<Task> tasks;
  for (int i = 1; i <= 10'000; ++i) tasks.push_back({1us * i, 0});
  for (auto _ : state) benchmark::DoNotOptimize(Table::build(tasks).ok());
}
BENCHMARK(RejectionOfRoundPeriods)->Unit(benchmark::kMillisecond);

void PlanOfAThousandModulesWithBudgets(benchmark::State& state) {
  model::Cell cell;
  cell.devices.emplace_back().executors.emplace_back();
  for (const Task& task : thousand_modules()) {
    model::Module& module = cell.devices.front().modules.emplace_back();
    module.name = "m" + std::to_string(cell.devices.front().modules.size());
    module.period = task.period;
    module.priority = task.priority;
    module.executor = "main";
    module.budget = 1us;
  }
  for (auto _ : state) {
    const auto planned = plan(cell);
    if (!planned) {
      state.SkipWithError(to_text(planned.problems()).c_str());
      return;
    }
  }
}
BENCHMARK(PlanOfAThousandModulesWithBudgets)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace takt::schedule
BENCHMARK_MAIN();
