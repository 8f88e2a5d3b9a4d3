// Removes modules from the tables while rows run as fast as possible. After a removal, no code of the module
// runs, so other threads may access the module's data.
#include <takt/channel/removal.hpp>

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <memory>
#include <random>
#include <thread>
#include <vector>

#include <takt/channel/link.hpp>

#include "fake_device.hpp"

namespace takt::executor::removal_test {
namespace {

using std::chrono::milliseconds;
constexpr auto kThread = model::ModuleType::thread;

/// A clock that advances by a nanosecond each time it is read. walk_row() sets the clock to the release time
/// of the row, because otherwise the rows would drift away from the grid.
class TickingClock final : public Clock {
 public:
  Instant now() noexcept override { return from_ns(ticks_.fetch_add(1, std::memory_order_relaxed)); }
  void reach(Instant instant) noexcept { ticks_.store(to_ns(instant), std::memory_order_relaxed); }

 private:
  std::atomic<std::int64_t> ticks_{1'000'000'000};
};

std::uint32_t walk_row(Executor& executor, TickingClock& clock) {
  clock.reach(executor.next_release());
  return executor.run_cycle(executor.next_release());
}

model::Module immediate(Nanoseconds deadline) {
  model::Module module = sporadic(kThread, deadline);
  module.dispatch = model::Dispatch::immediate;
  return module;
}

/// Data that run() and condition() share with the removing thread. Only the removal synchronizes the
/// accesses.
struct Shared {
  std::atomic<bool> inside{false};
  std::uint64_t plain = 0;
  std::uint64_t calls = 0;

  void touch() {
    inside.store(true, std::memory_order_relaxed);
    ++plain;
    ++calls;
    inside.store(false, std::memory_order_relaxed);
  }
};

TEST(Removal, IsOverOnlyWhenNoCodeOfTheModuleRuns) {
  // One periodic module, one sporadic module that rows release, and one sporadic module with immediate
  // dispatch.
  constexpr std::size_t kModules = 3;
  constexpr std::uint64_t kTimes = 1'500;
  FakeDevice device{
      {thread(milliseconds{1}), sporadic(kThread, milliseconds{5}), immediate(milliseconds{5})}};
  TickingClock clock;
  Executor executor{device.plan.executors[0], device.periodic_units, device.sporadic_units, *device.block,
                    clock};
  std::array<Shared, kModules> shared;
  for (std::size_t i = 0; i < kModules; ++i) {
    device.bodies[i].on_news = [] { return true; };
    device.bodies[i].on_condition = [&shared, i](bool* ready) -> const char* {
      shared[i].touch();
      *ready = true;
      return nullptr;
    };
    device.bodies[i].on_run = [&shared, i](const Cycle&) -> const char* {
      shared[i].touch();
      return nullptr;
    };
  }
  executor.join_grid(from_ns(2'000'000'000), from_ns(2'000'000'000));
  std::atomic<bool> end{false};
  std::thread rows{[&] {
    while (!end.load(std::memory_order_relaxed)) walk_row(executor, clock);
  }};
  std::thread sporadics{[&] {
    while (!end.load(std::memory_order_relaxed)) {
      if (!executor.run_sporadic()) std::this_thread::yield();
    }
  }};

  std::mt19937 random{5};
  std::array<channel::Removal, kModules> removals;
  std::array<std::uint64_t, kModules> outs{};
  const auto busy = [&] {  // true until each module has often run and has often been removed
    for (std::size_t i = 0; i < kModules; ++i) {
      if (device.blocks[i].cycles.load(std::memory_order_relaxed) < kTimes || outs[i] < kTimes / kModules)
        return true;
    }
    return false;
  };
  std::uint64_t met = 0;
  while (busy() && met == 0) {
    const std::size_t i = random() % kModules;
    const channel::ModuleMemory place{.index = static_cast<std::uint32_t>(i),
                                      .block = &device.blocks[i],
                                      .executor = device.block.get(),
                                      .slot = nullptr};
    removals[i].begin(place);
    while (!removals[i].over(place)) std::this_thread::yield();
    for (int look = 0; look < 20; ++look) met += shared[i].inside.load(std::memory_order_relaxed) ? 1 : 0;
    ++shared[i].plain;
    ++outs[i];
    channel::put_in(place);
    for (auto wait = random() % 300; wait > 0; --wait) static_cast<void>(removals[i].over(place));
  }
  end = true;
  rows.join();
  sporadics.join();
  EXPECT_EQ(met, 0U) << "a module ran after its removal";
  for (std::size_t i = 0; i < kModules; ++i) EXPECT_EQ(shared[i].plain, shared[i].calls + outs[i]) << i;
}

// A row checks whether the module has unread events while the sporadic thread may be reading these events.
TEST(ImmediateModule, CanBeCheckedForEventsByARowWhileItRuns) {
  constexpr std::uint64_t kEvents = 20'000;
  FakeDevice device{{thread(milliseconds{1}), immediate(milliseconds{5})}};
  TickingClock clock;
  Executor executor{device.plan.executors[0], device.periodic_units, device.sporadic_units, *device.block,
                    clock};
  const channel::Link::Options options{.depth = 64, .payload = 8, .is_queue = true};
  std::vector<std::byte> memory(channel::Link::layout(options).size() + 64);
  void* place = memory.data();
  std::size_t space = memory.size();
  auto* aligned = static_cast<std::byte*>(std::align(64, memory.size() - 64, place, space));
  channel::Link::format(aligned, options);
  channel::LinkWriter writer{channel::Link{aligned}};
  channel::LinkReader reader{channel::Link{aligned}};
  std::uint64_t written = 0;
  device.bodies[0].on_run = [&](const Cycle& cycle) -> const char* {
    if (written++ < kEvents) writer.publish(8, to_ns(cycle.start));
    return nullptr;
  };
  std::atomic<std::uint64_t> taken{0};
  device.bodies[1].on_news = [&] { return reader.has_news(); };
  device.bodies[1].on_condition = [&](bool* ready) -> const char* {
    *ready = reader.has_news();
    return nullptr;
  };
  device.bodies[1].on_run = [&](const Cycle&) -> const char* {
    while (reader.take()) ++taken;
    return nullptr;
  };
  executor.join_grid(from_ns(2'000'000'000), from_ns(2'000'000'000));
  std::atomic<bool> end{false};
  std::thread sporadics{[&] {
    while (!end.load(std::memory_order_relaxed)) {
      if (!executor.run_sporadic()) std::this_thread::yield();
    }
  }};
  while (written < kEvents) walk_row(executor, clock);
  const auto& block = channel::Link{aligned}.block();
  while (taken.load() + block.overwritten.load() < kEvents) {
    EXPECT_EQ(walk_row(executor, clock) & ~channel::kSporadicBit, 0U);
    std::this_thread::yield();
  }
  end = true;
  sporadics.join();
  EXPECT_EQ(taken.load() + block.overwritten.load(), kEvents);
  EXPECT_GT(taken.load(), 0U);
}

/// Tests step by step which activities a removal waits for.
class RemovalStep : public testing::Test {
 protected:
  std::unique_ptr<channel::ExecutorBlock> executor = std::make_unique<channel::ExecutorBlock>();
  std::unique_ptr<channel::ModuleBlock> block = std::make_unique<channel::ModuleBlock>();
  channel::ReleaseSlot slot{};
  channel::ModuleMemory place{.index = 4, .block = block.get(), .executor = executor.get(), .slot = nullptr};
  channel::Removal removal;
};

TEST_F(RemovalStep, WaitsOnlyForTheCurrentRow) {
  channel::put_in(place);
  EXPECT_FALSE(removal.over(place)) << "it is in the tables";
  executor->row_sequence = 7;
  removal.begin(place);
  EXPECT_FALSE(removal.over(place));
  executor->row_sequence = 8;
  EXPECT_TRUE(removal.over(place));
  executor->row_sequence = 9;
  EXPECT_TRUE(removal.over(place)) << "the next row sees that the module is out";
}

TEST_F(RemovalStep, DoesNotWaitIfNoRowIsInProgress) {
  executor->row_sequence = 8;
  removal.begin(place);
  EXPECT_TRUE(removal.over(place));
}

TEST_F(RemovalStep, WaitsOnlyForTheModulesOwnSporadicAndBackgroundRuns) {
  removal.begin(place);
  executor->sporadic.begin(3, channel::Doing::run, 0);
  EXPECT_TRUE(removal.over(place)) << "the sporadic run of another module";
  executor->sporadic.begin(4, channel::Doing::run, 0);
  EXPECT_FALSE(removal.over(place));
  executor->sporadic.end();
  block->background.begin(4, channel::Doing::run, 0);
  EXPECT_FALSE(removal.over(place));
  block->background.end();
  EXPECT_TRUE(removal.over(place));
}

TEST_F(RemovalStep, WaitsForTheProgramToFinishItsBody) {
  place.slot = &slot;
  slot.phase = channel::ReleaseSlotPhase::ready;
  channel::put_in(place);
  EXPECT_EQ(channel::release(slot, 0, 0), channel::Release::given);
  removal.begin(place);
  EXPECT_FALSE(removal.over(place));
  slot.done = 1;
  EXPECT_TRUE(removal.over(place));
  EXPECT_EQ(slot.open.load(), 0U);
  channel::clear_for_new_program(slot);
  EXPECT_TRUE(removal.over(place)) << "without a program there is no body to wait for";
}

}  // namespace
}  // namespace takt::executor::removal_test
