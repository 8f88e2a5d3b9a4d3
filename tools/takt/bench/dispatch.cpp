// takt bench dispatch: measures the cost of calling modules from a table.
#include <atomic>
#include <memory>
#include <string>

#include <fmt/format.h>

#include <takt/channel/flight_record.hpp>
#include <takt/channel/layout.hpp>
#include <takt/channel/release_slot.hpp>
#include <takt/core/check.hpp>
#include <takt/executor/executor.hpp>
#include <takt/model/cell.hpp>
#include <takt/os/clock.hpp>
#include <takt/os/futex.hpp>
#include <takt/os/platform.hpp>
#include <takt/os/real_time.hpp>
#include <takt/os/waker.hpp>
#include <takt/schedule/plan.hpp>

#include "bare_loop.hpp"
#include "benchmarks.hpp"
#include "modules/filter_step.hpp"
#include "timed.hpp"

namespace takt::bench {

namespace {

using namespace std::chrono_literals;

constexpr double kDispatchSeconds = 3;
constexpr int kDispatchTurns = 3;
constexpr std::size_t kMany = 1000;
constexpr Nanoseconds kDispatchPeriod = 1ms;

double chain = 1;

class Module final : public executor::Body {
 public:
  // Each module uses the result of the previous module, as in a control chain. Otherwise the CPU would
  // execute several calls at the same time, and the work of one module would seem too short.
  executor::Outcome run(const Cycle&) noexcept override {
    chain = 1 - work_.step(chain);
    return {};
  }
  executor::Outcome condition(const Cycle&, bool*) noexcept override { return {}; }

 private:
  Work work_;
};

/// An executor with N periodic modules of one type in one row, set up as in a host. The benchmark can also
/// call thread modules without the executor.
class Table {
 public:
  explicit Table(std::size_t n, model::ModuleType type = model::ModuleType::thread,
                 channel::FlightWriter* record = nullptr)
      : blocks_(std::make_unique<channel::ModuleBlock[]>(n)),
        slots_(std::make_unique<channel::ReleaseSlot[]>(n)),
        count_(n),
        bodies_(n) {
    model::Device device;
    device.executors.emplace_back();
    const bool thread = type == model::ModuleType::thread;
    std::vector<executor::Unit> units;
    for (std::size_t i = 0; i < n; ++i) {
      model::Module module;
      module.name = "m" + std::to_string(i);
      module.executor = device.executors.front().name;
      module.period = kDispatchPeriod;
      module.type = type;
      device.modules.push_back(module);
      blocks_[i].in_tables.store(1);
      slots_[i].phase.store(channel::ReleaseSlotPhase::ready);
      units.push_back({.index = static_cast<std::uint32_t>(i),
                       .body = thread ? &bodies_[i] : nullptr,
                       .slot = thread ? nullptr : &slots_[i],
                       .block = &blocks_[i],
                       .period = kDispatchPeriod});
      bare_.push_back(&bodies_[i]);
    }
    const auto plan = *schedule::plan(model::Cell{}, device);
    executor_ = std::make_unique<executor::Executor>(plan.executors[0], units, std::vector<executor::Unit>{},
                                                     block_, clock_, executor::Flight{record, nullptr});
  }

  executor::Executor& executor() { return *executor_; }
  /// Runs all modules without the executor, with one indirect call each.
  void call_all() noexcept {
    for (executor::Body* body : bare_) static_cast<void>(body->run(cycle_));
  }
  /// Reports, in place of each process module, that the module has finished its release.
  void answer_all() noexcept {
    for (std::size_t i = 0; i < count_; ++i)
      slots_[i].done.store(slots_[i].released.load(std::memory_order_relaxed), std::memory_order_relaxed);
  }
  /// True if every row has called or released every module.
  [[nodiscard]] bool all_served() const noexcept {
    for (std::size_t i = 0; i < count_; ++i) {
      if (blocks_[i].cycles.load() != block_.cycles.load()) return false;
    }
    return true;
  }

 private:
  std::unique_ptr<channel::ModuleBlock[]> blocks_;
  std::unique_ptr<channel::ReleaseSlot[]> slots_;
  std::size_t count_;
  std::vector<Module> bodies_;
  std::vector<executor::Body*> bare_;
  Cycle cycle_{};
  channel::ExecutorBlock block_{};
  os::MonotonicClock clock_;
  std::unique_ptr<executor::Executor> executor_;
};

// ---- Rows that run without pauses between them

Result<Section> row_after_row(const Scheduling& scheduling, Nanoseconds length, Course& course,
                              Problems& refused) {
  Section section{.title = "rows of thread modules, without pauses between rows: ns",
                  .columns = {"row", "bare calls", "a module", "beyond it"}};
  for (const std::size_t n : {10U, 100U, 1000U}) {
    double row = 0;
    double calls = 0;
    course.next(fmt::format("a row of {} modules", n));
    const auto loop = run_at(scheduling, [&] {
      Table table{n};
      executor::Executor& executor = table.executor();
      executor.join_grid(os::now(), os::now());
      // Pass the time at which the row is due, not the current time. The rows run without pauses, so each row
      // runs before it is due.
      std::vector<double> times = each_by_turns(
          length, {[&] { executor.run_cycle(executor.next_release()); }, [&] { table.call_all(); }});
      TAKT_CHECK(table.all_served());
      row = times[0];
      calls = times[1];
      return Loop{};
    });
    if (!loop) return loop.problems();
    add_once(refused, loop->refused);
    const auto count = static_cast<double>(n);
    section.rows.push_back({fmt::format("{} modules", n), {row, calls, row / count, (row - calls) / count}});
  }
  double released = 0;
  double clock = 0;
  course.next("a row of process modules");
  const auto loop = run_at(scheduling, [&] {
    constexpr std::size_t kPrograms = 100;
    Table table{kPrograms, model::ModuleType::process};
    executor::Executor& executor = table.executor();
    executor.join_grid(os::now(), os::now());
    const std::vector<double> times = each_by_turns(length, {[&] {
                                                               executor.run_cycle(executor.next_release());
                                                               table.answer_all();
                                                             },
                                                             [] { static_cast<void>(os::now()); }});
    TAKT_CHECK(table.all_served());
    released = times[0] / kPrograms;
    clock = times[1];
    return Loop{};
  });
  if (!loop) return loop.problems();
  section.notes.push_back(
      fmt::format("Releasing a process module and handling its answer takes {:.1f} ns. Reading the clock "
                  "takes {:.1f} ns.",
                  released, clock));
  section.notes.emplace_back(
      "bare calls: the same functions, called without a table. beyond it: the cost of a module on top of its "
      "own work.");
  return section;
}

/// Measures the cost of the flight record: alternately runs rows with and without it.
Result<Section> recorded(const Scheduling& scheduling, Nanoseconds length, Course& course,
                         Problems& refused) {
  Section section{.title = "cost of the flight record, per run of a module: ns",
                  .columns = {"a module, not recorded", "recorded", "a run's entry", "a bare entry"}};
  constexpr std::uint64_t kEntries = 1U << 18;  // 4 MiB, the size for a device with ten modules at 1 ms
  auto memory = channel::FlightRecord::create({kEntries, kEntries});
  if (!memory) return memory.problems();
  for (const std::size_t n : {10U, 100U, 1000U}) {
    std::vector<double> times;
    course.next(fmt::format("the flight record of {} modules", n));
    const auto loop = run_at(scheduling, [&] {
      channel::FlightWriter writer = memory->writer(0);
      channel::FlightWriter bare = memory->writer(1);
      Table with{n, model::ModuleType::thread, &writer};
      Table without{n};
      for (Table* table : {&with, &without}) table->executor().join_grid(os::now(), os::now());
      std::int64_t time_ns = 0;
      times = each_by_turns(length, {[&] { without.executor().run_cycle(without.executor().next_release()); },
                                     [&] { with.executor().run_cycle(with.executor().next_release()); },
                                     [&] {
                                       for (std::uint32_t i = 0; i < 100; ++i)
                                         bare.add(channel::FlightKind::run, ++time_ns, i, 5);
                                     }});
      TAKT_CHECK(with.all_served() && without.all_served());
      return Loop{};
    });
    if (!loop) return loop.problems();
    add_once(refused, loop->refused);
    const auto count = static_cast<double>(n);
    section.rows.push_back(
        {fmt::format("{} modules", n),
         {times[0] / count, times[1] / count, (times[1] - times[0]) / (count + 2), times[2] / 100}});
  }
  section.notes.emplace_back(
      "The flight record gets one entry when a row of the executor's table begins, one when it ends, and one "
      "for "
      "each run of a module. Target: at most 25 ns per entry.");
  return section;
}

// ---- A thousand modules at 1 ms

/// The measurements of one way to run the modules: one table, bare calls, or one thread per module.
struct SeenCycles {
  Loop loop;
  std::vector<std::int64_t> taken;  ///< duration of each cycle in ns
};

Loop walk_table(Table& table, const Grid& grid, std::vector<std::int64_t>& taken) {
  const std::atomic<std::uint32_t> stop{0};
  os::Waker waker{model::Wakeup::hybrid, os::margin_cap(grid.period, model::Executor{}.spin_share), stop};
  executor::Executor& executor = table.executor();
  executor.join_grid(grid.first, os::now());
  Instant began{};
  return loop_on_grid(
      grid, [&](Instant release) { return began = waker.wait_until(release); },
      [&](Instant) {
        executor.run_cycle(began);
        taken.push_back((os::now() - began).count());
      });
}

Loop call_bare(Table& table, const Grid& grid, std::vector<std::int64_t>& taken) {
  const std::atomic<std::uint32_t> stop{0};
  os::Waker waker{model::Wakeup::hybrid, os::margin_cap(grid.period, model::Executor{}.spin_share), stop};
  Instant began{};
  return loop_on_grid(
      grid, [&](Instant release) { return began = waker.wait_until(release); },
      [&](Instant) {
        table.call_all();
        taken.push_back((os::now() - began).count());
      });
}

Result<Loop> a_thread_for_each(const Scheduling& scheduling, Nanoseconds length) {
  std::vector<Loop> loops(kMany);
  std::vector<os::Thread> threads;
  std::atomic<std::uint32_t> go{0};
  Grid grid{.period = kDispatchPeriod, .length = length};
  Problems refused;
  for (Loop& loop : loops) {
    auto thread = os::Thread::start(
        {.name = "bench",
         .priority = scheduling.priority,
         .cpus = {scheduling.cpu},
         .stack_bytes = 64 * 1024},
        [&] {
          Module module;
          while (go.load(std::memory_order_acquire) == 0) os::futex_wait(go, 0, ~0U);
          loop = loop_on_grid(grid, sleep_to, [&module](Instant) { static_cast<void>(module.run({})); });
        },
        refused.empty() ? &refused : nullptr);
    if (!thread) {
      go.store(1, std::memory_order_release);
      os::futex_wake(go, ~0U);
      return thread.problems();
    }
    threads.push_back(std::move(*thread));
  }
  grid.first = os::now() + 100ms;
  go.store(1, std::memory_order_release);
  os::futex_wake(go, ~0U);
  for (os::Thread& thread : threads) thread.join();
  Loop all;
  for (const Loop& loop : loops) all.add(loop);
  all.refused = refused;
  return all;
}

Row row_of(const std::string& name, const SeenCycles& seen, Nanoseconds length) {
  const Distribution jitter = distribution_of(seen.loop.jitter);
  const Distribution taken = distribution_of(seen.taken);
  const bool one = taken.count != 0;
  const auto cycles = static_cast<double>(length / kDispatchPeriod);
  return {name,
          {static_cast<double>(seen.loop.cpu_time.count()) / 1e3 / cycles,
           one ? taken.p50 / 1e3 : std::nan(""), one ? taken.p99 / 1e3 : std::nan(""), jitter.p50 / 1e3,
           jitter.p99 / 1e3, jitter.max / 1e3, static_cast<double>(seen.loop.missed)}};
}

Result<Section> a_thousand(const Scheduling& scheduling, Nanoseconds length, Course& course,
                           Problems& refused) {
  SeenCycles table;
  SeenCycles bare;
  SeenCycles threads;
  Table modules{kMany};
  for (int turn = 0; turn < kDispatchTurns; ++turn) {
    for (SeenCycles* seen : {&table, &bare}) {
      course.next(fmt::format("{} modules: {}", kMany, seen == &table ? "one table" : "bare calls"));
      seen->taken.reserve(seen->taken.size() + static_cast<std::size_t>(length / kDispatchPeriod));
      const auto loop = run_at(scheduling, [&] {
        const Grid grid = Grid::from_now(kDispatchPeriod, length / kDispatchTurns);
        return seen == &table ? walk_table(modules, grid, seen->taken)
                              : call_bare(modules, grid, seen->taken);
      });
      if (!loop) return loop.problems();
      seen->loop.add(*loop);
    }
    course.next(fmt::format("{} modules: one thread per module", kMany));
    const auto all = a_thread_for_each(scheduling, length / kDispatchTurns);
    if (!all) return all.problems();
    threads.loop.add(*all);
  }
  for (const SeenCycles* seen : {&table, &bare, &threads}) add_once(refused, seen->loop.refused);
  Section section{
      .title = fmt::format("{} modules every {}, on CPU {} with priority {}: us", kMany,
                           takt::to_text(kDispatchPeriod), scheduling.cpu, scheduling.priority),
      .columns = {"processor", "cycle p50", "cycle p99", "jitter p50", "jitter p99", "jitter max", "missed"}};
  section.rows = {row_of("one table", table, length), row_of("bare calls", bare, length),
                  row_of("one thread per module", threads, length)};
  const Distribution of_table = distribution_of(table.taken);
  const Distribution of_calls = distribution_of(bare.taken);
  const auto ratio = [](Nanoseconds a, Nanoseconds b) {
    return b.count() == 0 ? 0 : static_cast<double>(a.count()) / static_cast<double>(b.count());
  };
  section.notes = {
      "processor: CPU time per period; for the table, it includes the wake-up, which spins. cycle: from the",
      "start of the first module to the end of the last one. jitter: for the table, the jitter of its first "
      "module.",
      fmt::format("Besides the modules' own work, the table takes {:.1f} us (p50) and {:.1f} us (p99) per "
                  "cycle; target: at most 60 us.",
                  (of_table.p50 - of_calls.p50) / 1e3, (of_table.p99 - of_calls.p99) / 1e3),
      fmt::format(
          "One thread per module takes {:.1f} times the CPU time of the table, and misses {} of {} cycles.",
          ratio(threads.loop.cpu_time, table.loop.cpu_time), threads.loop.missed,
          threads.loop.missed + threads.loop.jitter.size())};
  return section;
}

}  // namespace

Result<std::vector<Section>> dispatch(const Settings& settings, Problems& refused) {
  const Scheduling scheduling{.cpu = cpu_of(settings)};
  const Nanoseconds length = settings.length(kDispatchSeconds);
  Course course{settings, 4 + 3 + 3 * kDispatchTurns};
  auto rows = row_after_row(scheduling, length / 3, course, refused);
  if (!rows) return rows.problems();
  auto record = recorded(scheduling, length / 3, course, refused);
  if (!record) return record.problems();
  auto thousand = a_thousand(scheduling, length, course, refused);
  if (!thousand) return thousand.problems();
  return std::vector<Section>{std::move(*rows), std::move(*record), std::move(*thousand)};
}

}  // namespace takt::bench
