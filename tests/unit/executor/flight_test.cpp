// Compares the entries that an executor writes to its flight record with a model, which notes each call of a
// body.
#include <takt/channel/flight_record.hpp>
#include <takt/executor/executor.hpp>

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "fake_device.hpp"

namespace takt::executor::flight_test {
namespace {

using namespace std::chrono_literals;
using channel::FlightKind;
using channel::FlightRecord;
using channel::FlightSample;

class ExecutorRecording : public testing::Test {
 protected:
  void record(FakeDevice& device, std::uint64_t capacity = 1U << 20) {
    memory = std::move(*FlightRecord::create({capacity, capacity}));
    rows = memory.writer(FlightRecord::of_rows(0));
    runs = memory.writer(FlightRecord::of_sporadic(0));
    device.flight = {&rows, &runs};
    device.make_executor();
  }
  std::vector<FlightSample> of_rows() const { return memory.copy(0).entries; }
  std::vector<FlightSample> of_sporadic() const { return memory.copy(1).entries; }

  FlightRecord memory;
  channel::FlightWriter rows;
  channel::FlightWriter runs;
};

std::int64_t ns(Instant instant) { return to_ns(instant); }

TEST_F(ExecutorRecording, HasTheExpectedEntriesOverThousandsOfRows) {
  FakeDevice device{{thread(1ms), thread(2ms), thread(3ms), process(2ms, -1)}};
  record(device);
  std::mt19937 random{7};
  std::vector<FlightSample> expected;
  for (std::uint32_t i = 0; i < 3; ++i) {
    device.bodies[i].on_run = [&, i](const Cycle& cycle) -> const char* {
      EXPECT_EQ(cycle.start, device.clock.time);
      const Nanoseconds took{std::uniform_int_distribution<>{100, 600'000}(random)};
      device.clock.time += took;
      expected.push_back(
          {ns(device.clock.time), FlightKind::run, i, static_cast<std::uint64_t>(took.count())});
      return nullptr;
    };
  }
  device.join();
  std::int64_t body_ended = 0;
  std::uint64_t body_took = 0;
  for (int i = 0; i < 5000; ++i) {
    // Before some of the rows, the program ends its body. When the other rows begin, the program is in its
    // body.
    channel::ReleaseSlot& slot = device.slots[3];
    if (slot.in_body() && i % 3 != 0) {
      body_took = 1000 + static_cast<std::uint64_t>(i);
      body_ended = ns(device.clock.time) - 10;
      slot.body_began_ns = body_ended - static_cast<std::int64_t>(body_took);
      slot.body_ended_ns = body_ended;
      slot.done.store(slot.released.load());
    } else {
      body_ended = 0;
    }
    const Instant due = device.executor->next_release();
    const std::uint64_t row = device.executor->next_row();
    const Nanoseconds delay{std::uniform_int_distribution<>{0, i % 50 == 0 ? 4'000'000 : 20'000}(random)};
    const Instant woke = std::max(device.clock.time, due) + delay;
    const std::uint64_t walked = row + static_cast<std::uint64_t>((woke - due) / 1ms);
    expected.push_back(
        {ns(woke), FlightKind::row, 0, static_cast<std::uint64_t>(((woke - due) % 1ms).count())});
    const std::size_t before = expected.size();
    if (walked % 2 == 0) {
      if (body_ended != 0) expected.push_back({body_ended, FlightKind::body, 3, body_took});
      const bool busy = slot.in_body();
      expected.push_back(
          {ns(woke), FlightKind::released, 3,
           static_cast<std::uint64_t>(busy ? channel::Release::busy : channel::Release::given)});
    }
    device.cycle(delay);
    const std::size_t runs_seen = static_cast<std::size_t>(
        std::count_if(expected.begin() + static_cast<std::ptrdiff_t>(before), expected.end(),
                      [](const FlightSample& e) { return e.kind == FlightKind::run; }));
    ASSERT_EQ(runs_seen, 1U + (walked % 2 == 0) + (walked % 3 == 0));
    expected.push_back({ns(device.clock.time), FlightKind::row_end, 0, 0});
    if (walked % 2 != 0 && body_ended != 0) {
      // The executor records the end of a body only at the next release of the program. So the test hides the
      // end of the body until then.
      const std::uint32_t done = slot.done.load();
      slot.done.store(done - 1);
    }
  }
  const auto entries = of_rows();
  ASSERT_EQ(entries.size(), expected.size());
  for (std::size_t i = 0; i < entries.size(); ++i) {
    ASSERT_EQ(entries[i].time_ns, expected[i].time_ns) << i;
    ASSERT_EQ(entries[i].kind, expected[i].kind) << i;
    ASSERT_EQ(entries[i].module, expected[i].module) << i;
    ASSERT_EQ(entries[i].value, expected[i].value) << i;
  }
}

TEST_F(ExecutorRecording, ShowsACatchUpRunInTheLateRow) {
  auto module = thread(1ms);
  module.overrun = model::OverrunContract{.what = model::Overrun::catch_up, .limit = 2};
  FakeDevice device{{module}};
  record(device);
  device.join();
  device.cycle();
  device.cycle(2500us);
  std::vector<FlightKind> kinds;
  for (const FlightSample& entry : of_rows()) kinds.push_back(entry.kind);
  using enum FlightKind;
  EXPECT_EQ(kinds, (std::vector{row, run, row_end, row, run, run, run, row_end}));
  EXPECT_EQ(of_rows()[3].value, 500'000U);
}

TEST_F(ExecutorRecording, ShowsASwapInTheRowInWhichItBegins) {
  auto module = thread(1ms);
  module.overrun = model::OverrunContract{.what = model::Overrun::catch_up, .limit = 2};
  FakeDevice device{{thread(1ms), module}};
  record(device);
  device.join();
  device.cycle();
  Script next;
  Exchange exchange{.index = 1, .body = &next, .runs = 2};
  device.executor->exchange(exchange);
  device.cycle(1500us);
  device.cycle();
  std::vector<std::pair<FlightKind, std::uint32_t>> seen;
  for (const FlightSample& entry : of_rows()) seen.emplace_back(entry.kind, entry.module);
  using enum FlightKind;
  const std::vector<std::pair<FlightKind, std::uint32_t>> expected{
      {row, 0}, {run, 0},     {run, 1}, {row_end, 0},                          //
      {row, 0}, {swapped, 1}, {run, 1}, {run, 0},     {run, 1}, {row_end, 0},  //
      {row, 0}, {run, 0},     {run, 1}, {row_end, 0}};
  EXPECT_EQ(seen, expected);
}

TEST_F(ExecutorRecording, PutsSporadicRunsIntoTheRingOfTheSporadicThread) {
  FakeDevice device{{thread(1ms), sporadic(model::ModuleType::thread, 5ms)}};
  record(device);
  device.bodies[1].on_condition = [](bool* ready) -> const char* {
    *ready = true;
    return nullptr;
  };
  device.bodies[1].on_run = [&](const Cycle&) -> const char* {
    device.clock.time += 40us;
    return nullptr;
  };
  device.join();
  device.cycle();
  EXPECT_TRUE(device.executor->run_sporadic());
  ASSERT_EQ(of_rows().size(), 4U);
  EXPECT_EQ(of_rows()[2].kind, FlightKind::ready);
  EXPECT_EQ(of_rows()[2].module, 1U);
  ASSERT_EQ(of_sporadic().size(), 1U);
  EXPECT_EQ(of_sporadic()[0], (FlightSample{ns(device.clock.time), FlightKind::run, 1, 40'000}));
}

TEST_F(ExecutorRecording, HasNoEntryForARemovedModule) {
  FakeDevice device{{thread(1ms)}};
  record(device);
  device.blocks[0].in_tables.store(0);
  device.join();
  device.cycle();
  ASSERT_EQ(of_rows().size(), 2U);
  EXPECT_EQ(of_rows()[1].kind, FlightKind::row_end);
}

TEST_F(ExecutorRecording, IsOptional) {
  FakeDevice device{{thread(1ms), process(1ms), sporadic(model::ModuleType::thread, 5ms)}};
  device.join();
  for (int i = 0; i < 10; ++i) device.cycle();
  EXPECT_EQ(device.blocks[0].cycles.load(), 10U);
}

}  // namespace
}  // namespace takt::executor::flight_test
