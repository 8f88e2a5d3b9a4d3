// Compares a million cycles on virtual time with a model that follows only the paper. In the model, a module
// is due in slot n if its period divides n x basic period minus its offset. Modules run in the order of their
// priority, then of their position in the file. A module skips the releases of missed slots, unless its
// overrun contract is catch-up.
#include <gtest/gtest.h>
#include <full_form.hpp>

#include <algorithm>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "fake_device.hpp"

namespace takt::executor::grid_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr int kCyclesPerSeed = kSanitized ? 12'500 : 125'000;

/// A random number that depends only on its arguments, so that the model and the device draw the same number.
std::uint64_t noise(std::uint64_t a, std::uint64_t b) {
  std::uint64_t x = a * 0x9e3779b97f4a7c15U + b + 1;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9U;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebU;
  return x ^ (x >> 31);
}

/// A random duration: mostly short, occasionally longer than the basic period.
Nanoseconds duration(std::uint64_t seed, std::size_t module, std::uint64_t call, Nanoseconds basic) {
  const std::uint64_t n = noise(seed * 64 + module, call);
  const auto b = static_cast<std::uint64_t>(basic.count());
  if (n % 1000 == 0) return Nanoseconds{static_cast<std::int64_t>((n >> 10) % (9 * b))};
  if (n % 50 == 0) return Nanoseconds{static_cast<std::int64_t>((n >> 10) % b)};
  return Nanoseconds{static_cast<std::int64_t>((n >> 10) % (b / 20))};
}

struct Call {
  std::size_t module = 0;
  std::uint64_t number = 0;
  Instant time{};
  Nanoseconds period{};
  bool operator==(const Call&) const = default;
};

/// The counters that the model expects for one module.
struct Count {
  std::uint64_t cycles = 0;
  std::uint64_t missed = 0;
  std::uint64_t overruns = 0;
  Instant busy_until{};  // the end of the current body; used only for process modules
};

/// The model of an executor. The model counts slots from T0, and runs the row of each slot at most once.
struct Model {
  std::uint64_t seed;
  std::vector<model::Module> modules;
  std::vector<bool> in;  // true for each module in the tables
  Nanoseconds basic;
  Instant t0;
  std::vector<Count> counts;
  std::uint64_t slot = 0;
  std::uint64_t walked = 0;
  std::uint64_t skipped = 0;
  std::uint64_t late = 0;

  [[nodiscard]] Nanoseconds offset(std::size_t i) const { return modules[i].offset.value_or(Nanoseconds{0}); }
  [[nodiscard]] std::vector<std::size_t> due() const {
    std::vector<std::size_t> found;
    for (std::size_t i = 0; i < modules.size(); ++i) {
      const Nanoseconds at = basic * static_cast<std::int64_t>(slot) - offset(i);
      if (at >= Nanoseconds{0} && at % *modules[i].period == Nanoseconds{0}) found.push_back(i);
    }
    std::stable_sort(found.begin(), found.end(),
                     [this](auto a, auto b) { return modules[a].priority < modules[b].priority; });
    return found;
  }

  /// Computes what the executor must do when it wakes up at `now`. Returns the expected calls, and sets
  /// `done` to the time at which the last call ends.
  std::vector<Call> wake(Instant now, Instant* done) {
    struct Missed {
      std::uint64_t slot;
      std::size_t module;
    };
    std::vector<Missed> missed;
    while (now >= t0 + basic * static_cast<std::int64_t>(slot + 1)) {
      for (const std::size_t i : due()) {
        if (in[i]) missed.push_back({slot, i});
      }
      ++skipped;
      ++slot;
    }
    std::vector<Call> calls;
    const auto call = [&](std::size_t i, std::uint64_t at) {
      Count& count = counts[i];
      const Instant release = t0 + basic * static_cast<std::int64_t>(at);
      const Nanoseconds period = *modules[i].period;
      calls.push_back({.module = i,
                       .number = static_cast<std::uint64_t>((release - t0 - offset(i)) / period),
                       .time = release,
                       .period = period});
      now += duration(seed, i, count.cycles, basic);
      ++count.cycles;
      if (now > release + period) ++count.overruns;
    };
    for (std::size_t k = 0; k < missed.size(); ++k) {
      const std::size_t i = missed[k].module;
      const auto later = std::count_if(missed.begin() + static_cast<std::ptrdiff_t>(k) + 1, missed.end(),
                                       [i](const Missed& other) { return other.module == i; });
      const model::OverrunContract contract = modules[i].overrun.value_or(model::OverrunContract{});
      if (contract.what == model::Overrun::catch_up && later < contract.limit)
        call(i, missed[k].slot);
      else
        ++counts[i].missed;
    }
    for (const std::size_t i : due()) {
      if (!in[i]) continue;
      Count& count = counts[i];
      if (modules[i].type == model::ModuleType::thread) {
        call(i, slot);
      } else if (count.busy_until > now) {
        ++count.overruns;
      } else {
        count.busy_until = now + duration(seed, i, count.cycles, basic) * 4;
        ++count.cycles;
      }
    }
    ++walked;
    ++slot;
    if (now > t0 + basic * static_cast<std::int64_t>(slot)) ++late;
    *done = now;
    return calls;
  }
};

class Grid : public testing::TestWithParam<std::uint64_t> {};

TEST_P(Grid, StaysFixedDespiteOverrunsAndRemovedModules) {
  const std::uint64_t seed = GetParam();
  std::mt19937_64 random{seed};
  const auto draw = [&random](std::int64_t n) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
  };

  const std::vector<std::int64_t> factors{1, 1, 2, 3, 4, 5, 6, 8, 10, 12};
  const Nanoseconds unit = microseconds{10 + draw(100)};
  std::vector<model::Module> modules;
  for (std::int64_t n = 1 + draw(12); n > 0; --n) {
    const Nanoseconds period =
        unit * factors[static_cast<std::size_t>(draw(static_cast<std::int64_t>(factors.size())))];
    const int priority = static_cast<int>(draw(5)) - 2;
    modules.push_back(draw(10) < 7 ? thread(period, priority) : process(period, priority));
    if (draw(3) == 0) modules.back().offset = unit * draw(period / unit);
    if (modules.back().type == model::ModuleType::thread && draw(3) == 0) {
      modules.back().overrun = {.what = model::Overrun::catch_up, .limit = 1 + static_cast<int>(draw(4))};
    }
  }
  FakeDevice device{modules};
  device.join(microseconds{draw(500)});

  Model model{.seed = seed,
              .modules = modules,
              .in = std::vector<bool>(modules.size(), true),
              .basic = {},
              .t0 = device.t0,
              .counts = std::vector<Count>(modules.size())};
  std::int64_t basic = 0;
  for (const model::Module& module : modules) {
    basic = std::gcd(std::gcd(basic, module.period->count()), module.offset.value_or(Nanoseconds{0}).count());
  }
  model.basic = Nanoseconds{basic};

  // Advances time. Before that, each program checks its slot, as a real program does at any time.
  std::vector<std::uint64_t> served(modules.size());
  std::vector<Instant> busy_until(modules.size());
  const auto move_time_to = [&](Instant time) {
    for (std::size_t i = 0; i < modules.size(); ++i) {
      channel::ReleaseSlot& release_slot = device.slots[i];
      if (release_slot.released.load() != served[i]) {
        busy_until[i] = device.clock.time + duration(seed, i, served[i], model.basic) * 4;
        ++served[i];
      }
      if (busy_until[i] <= time) release_slot.done.store(static_cast<std::uint32_t>(served[i]));
    }
    device.clock.time = time;
  };
  std::vector<Call> calls;
  for (std::size_t i = 0; i < modules.size(); ++i) {
    device.bodies[i].on_run = [&, i, n = std::uint64_t{0}](const Cycle& cycle) mutable {
      calls.push_back({.module = i, .number = cycle.number, .time = cycle.time, .period = cycle.period});
      move_time_to(device.clock.time + duration(seed, i, n++, model.basic));
      return nullptr;
    };
  }

  for (int n = 0; n < kCyclesPerSeed; ++n) {
    Nanoseconds delay{draw(basic / 10 + 1)};
    if (draw(50) == 0) delay = Nanoseconds{draw(3 * basic)};
    if (draw(500) == 0) delay = Nanoseconds{basic * draw(100)};  // this wake-up is exactly on the grid
    if (draw(1000) == 0) {
      const auto i = static_cast<std::size_t>(draw(static_cast<std::int64_t>(modules.size())));
      model.in[i] = !model.in[i];
      device.blocks[i].in_tables.store(model.in[i] ? 1 : 0);
    }
    move_time_to(std::max(device.clock.time, device.executor->next_release()) + delay);

    const Instant now = device.clock.time;
    Instant done{};
    const std::vector<Call> expected = model.wake(now, &done);
    calls.clear();
    const std::uint32_t wake = device.executor->run_cycle(now);

    ASSERT_EQ(wake, 0U) << "no program sleeps";
    ASSERT_EQ(calls.size(), expected.size()) << "slot " << model.slot - 1;
    ASSERT_TRUE(calls == expected) << "slot " << model.slot - 1;
    ASSERT_EQ(device.clock.time, done);
    ASSERT_EQ(device.executor->next_row(), model.slot);
    ASSERT_EQ(device.executor->next_release(),
              device.t0 + model.basic * static_cast<std::int64_t>(model.slot));
    ASSERT_EQ(device.block->missed.load(), model.skipped);
    ASSERT_EQ(device.block->late.load(), model.late);
    for (std::size_t i = 0; i < modules.size(); ++i) {
      ASSERT_EQ(device.blocks[i].cycles.load(), model.counts[i].cycles)
          << "module " << i << ", slot " << model.slot - 1;
      ASSERT_EQ(device.blocks[i].missed.load(), model.counts[i].missed)
          << "module " << i << ", slot " << model.slot - 1;
      ASSERT_EQ(device.blocks[i].overruns.load(), model.counts[i].overruns)
          << "module " << i << ", slot " << model.slot - 1;
    }
  }
  EXPECT_EQ(device.block->cycles.load(), model.walked);
  EXPECT_EQ(model.walked + model.skipped, model.slot);
  EXPECT_GT(model.skipped, 0U);
  EXPECT_EQ(device.block->jitter.read().count, model.walked);
  for (std::size_t i = 0; i < modules.size(); ++i) {
    const bool is_thread = modules[i].type == model::ModuleType::thread;
    EXPECT_EQ(device.blocks[i].run.read().count, is_thread ? model.counts[i].cycles : 0);
    EXPECT_EQ(device.blocks[i].jitter.read().count, is_thread ? model.counts[i].cycles : 0);
  }
}

TEST_P(Grid, EveryReleaseIsServedOrCountedAsMissedExactlyOnce) {
  const std::uint64_t seed = GetParam();
  std::mt19937_64 random{seed ^ 0xabcdef};
  std::vector<model::Module> modules{thread(microseconds{100}), thread(microseconds{300}),
                                     thread(microseconds{700}), process(microseconds{200}),
                                     process(microseconds{500}, -1)};
  FakeDevice device{modules};
  device.join();
  for (int n = 0; n < kCyclesPerSeed / 10; ++n) {
    for (std::size_t i : {3U, 4U}) {
      if (random() % 3 != 0) device.slots[i].done.store(device.slots[i].released.load());
    }
    device.cycle(random() % 20 == 0 ? microseconds{random() % 5000} : microseconds{random() % 100});
  }

  const std::uint64_t slots = device.executor->next_row();
  EXPECT_EQ(device.block->cycles.load() + device.block->missed.load(), slots);
  for (std::size_t i = 0; i < modules.size(); ++i) {
    std::uint64_t due = 0;
    for (std::uint64_t slot = 0; slot < slots; ++slot) {
      if (slot * 100'000 % static_cast<std::uint64_t>(modules[i].period->count()) == 0) ++due;
    }
    const channel::ModuleBlock& block = device.blocks[i];
    const std::uint64_t busy = modules[i].type == model::ModuleType::process ? block.overruns.load() : 0;
    EXPECT_EQ(block.cycles.load() + block.missed.load() + busy, due) << "module " << i;
    EXPECT_EQ(busy > 0, modules[i].type == model::ModuleType::process);
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, Grid, testing::Range<std::uint64_t>(1, 9));

TEST(Executor, RunsTheTableFromFigure3OfThePaper) {
  FakeDevice device{{thread(microseconds{600}, 4), thread(microseconds{100}, 3), thread(microseconds{100}, 2),
                     thread(microseconds{300}, 5)}};
  device.join();
  std::vector<std::string> rows;
  const std::vector<std::string> names{"c1 ", "c2 ", "c3 ", "c4 "};
  for (std::size_t i = 0; i < 4; ++i) {
    device.bodies[i].on_run = [&rows, &names, i](const Cycle&) {
      rows.back() += names[i];
      return nullptr;
    };
  }
  for (int row = 0; row < 7; ++row) {
    rows.emplace_back();
    device.cycle();
  }
  EXPECT_EQ(rows, (std::vector<std::string>{"c3 c2 c1 c4 ", "c3 c2 ", "c3 c2 ", "c3 c2 c4 ", "c3 c2 ",
                                            "c3 c2 ", "c3 c2 c1 c4 "}));
}

TEST(Executor, RunsARowInWhichNoModuleIsDue) {
  FakeDevice device{{thread(milliseconds{2}), thread(milliseconds{3})}};
  device.join();
  device.cycle();
  device.cycle();  // 1 ms: no module is due
  EXPECT_EQ(device.block->cycles.load(), 2U);
  EXPECT_EQ(device.blocks[0].cycles.load(), 1U);
  EXPECT_EQ(device.blocks[1].cycles.load(), 1U);
  EXPECT_EQ(device.executor->next_release(), device.t0 + milliseconds{2});
}

TEST(Executor, ChecksSporadicConditionsEvenWithoutPeriodicModules) {
  FakeDevice device{{sporadic(model::ModuleType::thread, milliseconds{10})}};
  device.join();
  EXPECT_EQ(device.executor->basic_period(), milliseconds{5});
  device.cycle();
  device.cycle(milliseconds{23});  // now at 28 ms: the slots at 5, 10, 15 and 20 ms are over
  EXPECT_EQ(device.bodies[0].asked, 2);
  EXPECT_EQ(device.block->cycles.load(), 2U);
  EXPECT_EQ(device.block->missed.load(), 4U);
  EXPECT_EQ(device.executor->next_release(), device.t0 + milliseconds{30});
}

TEST(ExecutorDeathTest, AbortsIfItJoinsAGridWithoutModules) {
  FakeDevice device{{}};
  EXPECT_EQ(device.executor->basic_period(), Nanoseconds{0});
  EXPECT_DEATH(device.join(), "basic_ > Nanoseconds");
}

TEST(Executor, RunsAThousandModulesInOneRow) {
  std::vector<model::Module> modules;
  for (int i = 0; i < 1000; ++i) modules.push_back(thread(milliseconds{1}, -i));
  FakeDevice device{modules};
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < 1000; ++i) {
    device.bodies[i].on_run = [&order, i](const Cycle&) {
      order.push_back(i);
      return nullptr;
    };
  }
  device.join();
  device.cycle();
  ASSERT_EQ(order.size(), 1000U);
  EXPECT_TRUE(std::is_sorted(order.rbegin(), order.rend())) << "the lowest value runs first";
}

TEST(Executor, WaitsForAStartTimeInTheFuture) {
  FakeDevice device{{thread(milliseconds{1})}};
  Instant released{};
  device.bodies[0].on_run = [&released](const Cycle& cycle) {
    released = cycle.time;
    EXPECT_EQ(cycle.number, 0U);
    return nullptr;
  };
  device.join(milliseconds{250});
  EXPECT_EQ(device.executor->next_release(), device.t0);
  device.cycle();
  EXPECT_EQ(released, device.t0);
  EXPECT_EQ(device.block->missed.load(), 0U);
}

TEST(Executor, CountsRowsMissedDuringARestart) {
  FakeDevice device{{thread(milliseconds{1}), thread(milliseconds{2}), process(milliseconds{3})}};
  device.join();
  for (int i = 0; i < 5; ++i) device.cycle();  // rows 0 to 4

  device.make_executor();
  device.clock.time = device.t0 + microseconds{11'500};
  device.executor->join_grid(device.t0, device.clock.time);

  EXPECT_EQ(device.executor->next_row(), 12U) << "the first release that is not before now";
  EXPECT_EQ(device.block->next_row.load(), 12U);
  EXPECT_EQ(device.block->missed.load(), 7U);  // rows 5 to 11
  EXPECT_EQ(device.blocks[0].missed.load(), 7U);
  EXPECT_EQ(device.blocks[1].missed.load(), 3U);  // rows 6, 8 and 10
  EXPECT_EQ(device.blocks[2].missed.load(), 2U);  // rows 6 and 9
  std::uint64_t number = 0;
  device.bodies[0].on_run = [&number](const Cycle& cycle) {
    number = cycle.number;
    return nullptr;
  };
  device.cycle();
  EXPECT_EQ(number, 12U);
}

TEST(Executor, CountsRowsMissedBeforeItsEnd) {
  FakeDevice device{{thread(milliseconds{1}), thread(milliseconds{2})}};
  device.join();
  device.cycle();
  device.executor->leave_grid(device.t0 + microseconds{999});
  EXPECT_EQ(device.block->missed.load(), 0U) << "row 1 is not due yet";
  device.executor->leave_grid(device.t0 + microseconds{1'999});
  EXPECT_EQ(device.block->missed.load(), 0U) << "the time of row 1 is not over yet";
  device.executor->leave_grid(device.t0 + microseconds{4'999});
  EXPECT_EQ(device.block->missed.load(), 3U);  // rows 1 to 3
  EXPECT_EQ(device.blocks[0].missed.load(), 3U);
  EXPECT_EQ(device.blocks[1].missed.load(), 1U);  // row 2
  EXPECT_EQ(device.block->next_row.load(), 4U);
}

TEST(Executor, RecordsTheLargestRowDelay) {
  FakeDevice device{{thread(milliseconds{1})}};
  device.join();
  device.cycle();
  EXPECT_EQ(device.block->latest_ns.load(), 0);
  device.cycle(microseconds{300});
  device.cycle(microseconds{200});
  EXPECT_EQ(device.block->latest_ns.load(), 300'000);
  device.cycle(milliseconds{50});  // skips fifty rows; the row that runs is on time
  EXPECT_EQ(device.block->latest_ns.load(), 50'000'000);
  EXPECT_EQ(device.block->missed.load(), 50U);
  device.cycle();
  EXPECT_EQ(device.block->latest_ns.load(), 50'000'000);
}

TEST(Executor, JoinsTheGridAtAReleaseThatIsDueExactlyNow) {
  FakeDevice device{{thread(milliseconds{1})}};
  device.executor->join_grid(device.clock.time - milliseconds{4}, device.clock.time);
  EXPECT_EQ(device.executor->next_row(), 4U);
  EXPECT_EQ(device.executor->next_release(), device.clock.time);
  EXPECT_EQ(device.block->missed.load(), 4U);
}

TEST(Executor, DoesNotCountARowThatEndsExactlyWithItsSlotAsLate) {
  FakeDevice device{{thread(milliseconds{1})}};
  device.join();
  Nanoseconds takes = milliseconds{1};
  device.bodies[0].on_run = [&](const Cycle&) {
    device.clock.time += takes;
    return nullptr;
  };
  device.cycle();
  EXPECT_EQ(device.block->late.load(), 0U);
  EXPECT_EQ(device.blocks[0].overruns.load(), 0U);

  takes += Nanoseconds{1};
  device.cycle();
  EXPECT_EQ(device.block->late.load(), 1U);
  EXPECT_EQ(device.blocks[0].overruns.load(), 1U);
  EXPECT_EQ(device.block->missed.load(), 0U) << "the next row runs, late";
}

TEST(Executor, MeasuresJitterAsInEquation1OfThePaper) {
  FakeDevice device{{thread(milliseconds{1}), thread(milliseconds{1})}};
  device.bodies[0].on_run = [&device](const Cycle&) {
    device.clock.time += microseconds{40};
    return nullptr;
  };
  device.join();
  device.cycle(microseconds{3});
  EXPECT_DOUBLE_EQ(device.block->jitter.read().mean, -3'000);
  EXPECT_DOUBLE_EQ(device.blocks[0].jitter.read().mean, -3'000);
  EXPECT_DOUBLE_EQ(device.blocks[0].run.read().mean, 40'000);
  EXPECT_DOUBLE_EQ(device.blocks[1].jitter.read().mean, -43'000);
}

TEST(Executor, PublishesWhichModuleOfARowIsRunning) {
  FakeDevice device{{thread(milliseconds{1})}};
  device.bodies[0].on_run = [&device](const Cycle&) {
    EXPECT_EQ(device.block->row_sequence.load() % 2, 1U);
    EXPECT_EQ(device.block->row.module.load(), 1U);
    EXPECT_EQ(device.block->row.doing.load(), channel::Doing::run);
    EXPECT_EQ(device.block->row.since_ns.load(), to_ns(device.clock.time));
    return nullptr;
  };
  device.join();
  device.cycle();
  EXPECT_EQ(device.block->row_sequence.load() % 2, 0U);
  EXPECT_EQ(device.block->row.module.load(), 0U);
}

}  // namespace
}  // namespace takt::executor::grid_test
