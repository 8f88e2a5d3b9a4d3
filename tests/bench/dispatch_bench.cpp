// What it costs to be dispatched, beyond what the module itself does: one row of N empty modules on the
// machine's clock, beside a bare loop of N indirect calls. Aim: at most 40 ns a module.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <takt/channel/layout.hpp>
#include <takt/channel/seat.hpp>
#include <takt/core/statistics.hpp>
#include <takt/executor/executor.hpp>
#include <takt/model/cell.hpp>
#include <takt/os/clock.hpp>
#include <takt/schedule/plan.hpp>

#include "machine.hpp"

namespace takt::bench {
namespace {

class Empty final : public executor::Body {
 public:
  executor::Outcome run(const Cycle& cycle) noexcept override {
    benchmark::DoNotOptimize(cycle.number);
    return {};
  }
  executor::Outcome condition(const Cycle&, bool*) noexcept override { return {}; }
};

/// N periodic modules of one kind in one row, as a host sets them up.
struct Row {
  Row(std::size_t n, model::ModuleType type)
      : blocks(std::make_unique<channel::ModuleBlock[]>(n)),
        seats(std::make_unique<channel::Seat[]>(n)),
        bodies(n) {
    model::Device device;
    device.executors.emplace_back();
    std::vector<executor::Unit> units;
    for (std::size_t i = 0; i < n; ++i) {
      model::Module module;
      module.name = "m" + std::to_string(i);
      module.executor = "main";
      module.type = type;
      module.period = std::chrono::milliseconds{1};
      device.modules.push_back(module);
      blocks[i].in_tables.store(1);
      seats[i].phase.store(channel::SeatPhase::ready);
      const bool thread = type == model::ModuleType::thread;
      units.push_back({.index = static_cast<std::uint32_t>(i),
                       .body = thread ? &bodies[i] : nullptr,
                       .seat = thread ? nullptr : &seats[i],
                       .block = &blocks[i],
                       .period = *module.period});
    }
    const auto plan = *schedule::plan(model::Cell{}, device);
    executor = std::make_unique<executor::Executor>(plan.executors[0], units, std::vector<executor::Unit>{},
                                                    block, clock);
    executor->join_grid(os::now(), os::now());
  }

  std::unique_ptr<channel::ModuleBlock[]> blocks;
  std::unique_ptr<channel::Seat[]> seats;
  std::vector<Empty> bodies;
  channel::ExecutorBlock block{};
  os::MonotonicClock clock;
  std::unique_ptr<executor::Executor> executor;
};

void per_module(benchmark::State& state) {
  state.counters["per_module"] =
      benchmark::Counter(static_cast<double>(state.range(0)),
                         benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void thread_modules(benchmark::State& state) {
  Row row{static_cast<std::size_t>(state.range(0)), model::ModuleType::thread};
  // The instant of the release and not the clock's: a row takes less than its period here, so the grid is
  // ahead.
  for (auto _ : state) row.executor->run_cycle(row.executor->next_release());
  per_module(state);
}

// As after the sleep of a real cycle, in which others had the caches.
void thread_modules_cold(benchmark::State& state) {
  Row row{static_cast<std::size_t>(state.range(0)), model::ModuleType::thread};
  std::vector<std::uint64_t> others(2U << 20);  // 16 MB: more than the second level holds
  for (auto _ : state) {
    for (std::size_t i = 0; i < others.size(); i += 8) ++others[i];
    benchmark::ClobberMemory();
    const Instant start = os::now();
    row.executor->run_cycle(row.executor->next_release());
    state.SetIterationTime(std::chrono::duration<double>(os::now() - start).count());
  }
  per_module(state);
}

void indirect_calls(benchmark::State& state) {
  std::vector<Empty> bodies(static_cast<std::size_t>(state.range(0)));
  std::vector<executor::Body*> pointers;
  for (Empty& body : bodies) pointers.push_back(&body);
  benchmark::DoNotOptimize(pointers.data());
  Cycle cycle{};
  for (auto _ : state) {
    for (executor::Body* body : pointers) benchmark::DoNotOptimize(body->run(cycle));
    ++cycle.number;
  }
  per_module(state);
}

void process_modules(benchmark::State& state) {
  const auto n = static_cast<std::size_t>(state.range(0));
  Row row{n, model::ModuleType::process};
  for (auto _ : state) {
    row.executor->run_cycle(row.executor->next_release());
    for (std::size_t i = 0; i < n; ++i)
      row.seats[i].done.store(row.seats[i].released.load(), std::memory_order_relaxed);
  }
  per_module(state);
}

void record(benchmark::State& state) {
  auto statistics = std::make_unique<Statistics>();
  statistics->clear();
  std::int64_t value = 1;
  for (auto _ : state) {
    statistics->record(value & 0xffff);
    value = value * 5 + 1;
  }
}

void read_clock(benchmark::State& state) {
  os::MonotonicClock machine;
  Clock* clock = &machine;
  benchmark::DoNotOptimize(clock);
  for (auto _ : state) benchmark::DoNotOptimize(clock->now());
}

BENCHMARK(indirect_calls)->RangeMultiplier(10)->Range(1, 1000);
BENCHMARK(thread_modules)->RangeMultiplier(10)->Range(1, 1000);
BENCHMARK(thread_modules_cold)->RangeMultiplier(10)->Range(1, 1000)->UseManualTime()->Iterations(300);
BENCHMARK(process_modules)->RangeMultiplier(10)->Range(1, 1000);
BENCHMARK(record);
BENCHMARK(read_clock);

}  // namespace
}  // namespace takt::bench

int main(int argc, char** argv) {
  takt::bench::describe_machine();
  const takt::bench::Ticks before = takt::bench::ticks();
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  const takt::bench::Ticks after = takt::bench::ticks();
  const double all = static_cast<double>(after.all - before.all);
  std::fprintf(stderr, "stolen by other machines meanwhile: %.1f %%; load now: %s\n",
               all > 0 ? 100.0 * static_cast<double>(after.stolen - before.stolen) / all : 0.0,
               takt::bench::first_line("/proc/loadavg").c_str());
  return 0;
}
