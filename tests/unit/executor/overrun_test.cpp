// Tests the effect of each overrun contract, slot by slot, on virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "fake_device.hpp"

namespace takt::executor::overrun_test {
namespace {

using model::Overrun;
using std::chrono::microseconds;
using std::chrono::milliseconds;
using testing::ElementsAre;
using testing::IsEmpty;

model::Module with(model::Module module, Overrun what, int limit = 1) {
  module.overrun = model::OverrunContract{.what = what, .limit = limit};
  return module;
}

/// A device that records which module is called in which of the module's cycles: "0:3" is module 0 in its
/// cycle 3.
class OverrunContract : public testing::Test {
 protected:
  void make(std::vector<model::Module> modules) {
    const std::size_t count = modules.size();
    device = std::make_unique<FakeDevice>(std::move(modules));
    takes.assign(count, Nanoseconds{0});
    for (std::size_t i = 0; i < count; ++i) {
      device->bodies[i].on_run = [this, i](const Cycle& cycle) -> const char* {
        calls.push_back(std::to_string(i) + ":" + std::to_string(cycle.number));
        EXPECT_EQ(cycle.time, device->t0 + cycle.period * static_cast<std::int64_t>(cycle.number));
        device->clock.time += takes[i];
        return nullptr;
      };
    }
    device->join();
  }
  /// Wakes the executor `late` after the next release. Returns the calls in the row that runs then.
  std::vector<std::string> cycle(Nanoseconds late = Nanoseconds{0}) {
    calls.clear();
    device->cycle(late);
    return calls;
  }
  [[nodiscard]] std::uint64_t missed(std::size_t i) const { return device->blocks[i].missed.load(); }
  [[nodiscard]] std::uint64_t overruns(std::size_t i) const { return device->blocks[i].overruns.load(); }
  [[nodiscard]] ErrorType error(std::size_t i) const {
    return static_cast<ErrorType>(device->blocks[i].error.load());
  }

  std::unique_ptr<FakeDevice> device;
  std::vector<Nanoseconds> takes;
  std::vector<std::string> calls;
};

TEST_F(OverrunContract, SkipDoesNotMakeUpForMissedReleases) {
  make({thread(milliseconds{1}), thread(milliseconds{2})});
  EXPECT_THAT(cycle(), ElementsAre("0:0", "1:0"));
  EXPECT_THAT(cycle(microseconds{3'500}), ElementsAre("0:4", "1:2")) << "slots 1 to 3 are over";
  EXPECT_EQ(missed(0), 3U);
  EXPECT_EQ(missed(1), 1U);
  EXPECT_EQ(device->block->missed.load(), 3U);
  EXPECT_EQ(error(0), ErrorType::none);
}

TEST_F(OverrunContract, CatchUpRunsTheNewestMissedReleasesInOrder) {
  make({with(thread(milliseconds{1}, 1), Overrun::catch_up, 2), thread(milliseconds{1}, 2),
        with(thread(milliseconds{2}, 0), Overrun::catch_up, 5)});
  EXPECT_THAT(cycle(), ElementsAre("2:0", "0:0", "1:0"));
  EXPECT_THAT(cycle(microseconds{4'500}), ElementsAre("2:1", "0:3", "2:2", "0:4", "0:5", "1:5"))
      << "slots 1 to 4 are over; module 0 makes up for 3 and 4, module 2 for its releases in slots 2 and 4";
  EXPECT_EQ(missed(0), 2U) << "two releases exceed the limit";
  EXPECT_EQ(missed(1), 4U);
  EXPECT_EQ(missed(2), 0U);
  EXPECT_EQ(device->blocks[0].cycles.load(), 4U);
  EXPECT_EQ(overruns(0), 2U) << "both runs ended after the next release of the module";
  EXPECT_EQ(overruns(2), 1U) << "its cycle 2 ended before 6 ms";
  EXPECT_EQ(device->block->missed.load(), 4U) << "the slots were still missed";
  EXPECT_EQ(device->executor->next_release(), device->t0 + milliseconds{6}) << "the grid is kept";
  EXPECT_THAT(cycle(), ElementsAre("2:3", "0:6", "1:6"));
}

TEST_F(OverrunContract, CatchUpAlsoMakesUpForReleasesMissedBySlowRuns) {
  make({with(thread(milliseconds{1}), Overrun::catch_up, 1)});
  takes[0] = microseconds{1'400};
  EXPECT_THAT(cycle(), ElementsAre("0:0"));
  // The first run ends at 1.4 ms. The slot that began at 1 ms is not over then, so its row runs late, until
  // 2.8 ms. Each row starts later than the previous row, until a slot is missed.
  EXPECT_THAT(cycle(), ElementsAre("0:1"));
  EXPECT_THAT(cycle(), ElementsAre("0:2")) << "2.8 to 4.2 ms";
  EXPECT_THAT(cycle(), ElementsAre("0:3", "0:4")) << "4.2 ms: cycle 3 is made up for, and 4 runs late";
  EXPECT_EQ(missed(0), 0U);
  EXPECT_THAT(cycle(), ElementsAre("0:6", "0:7")) << "7 ms: cycle 5 exceeds the limit";
  EXPECT_EQ(missed(0), 1U);
}

TEST_F(OverrunContract, CatchUpStopsWhenTheModuleIsRemoved) {
  make({with(thread(milliseconds{1}), Overrun::catch_up, 3)});
  EXPECT_THAT(cycle(), ElementsAre("0:0"));
  device->bodies[0].on_run = [this](const Cycle& cycle) {
    calls.push_back("0:" + std::to_string(cycle.number));
    return "it broke";
  };
  EXPECT_THAT(cycle(microseconds{3'500}), ElementsAre("0:1"));
  EXPECT_EQ(missed(0), 2U);
  EXPECT_EQ(device->blocks[0].cycles.load(), 2U);
}

TEST_F(OverrunContract, CatchUpDoesNotRunReleasesMissedDuringAHostRestart) {
  make({with(thread(milliseconds{1}), Overrun::catch_up, 100)});
  cycle();
  device->make_executor();
  device->clock.time += milliseconds{10};
  device->executor->join_grid(device->t0, device->clock.time);
  EXPECT_EQ(missed(0), 9U);
  EXPECT_THAT(cycle(), ElementsAre("0:10"));
}

TEST_F(OverrunContract, CatchUpRespectsTheOffset) {
  model::Module shifted = with(thread(milliseconds{2}), Overrun::catch_up, 2);
  shifted.offset = milliseconds{1};
  make({shifted, thread(milliseconds{1})});
  device->bodies[0].on_run = [this](const Cycle& cycle) {
    calls.push_back("0:" + std::to_string(cycle.number));
    EXPECT_EQ(cycle.time,
              device->t0 + milliseconds{1} + cycle.period * static_cast<std::int64_t>(cycle.number));
    return nullptr;
  };
  EXPECT_THAT(cycle(), ElementsAre("1:0"));
  EXPECT_THAT(cycle(), ElementsAre("0:0", "1:1"));
  EXPECT_THAT(cycle(microseconds{4'200}), ElementsAre("0:1", "0:2", "1:6")) << "slots 3 and 5 are over";
  EXPECT_EQ(missed(0), 0U);
  EXPECT_EQ(missed(1), 4U);
}

TEST_F(OverrunContract, ErrorRemovesAModuleThatMissesARelease) {
  make({with(thread(milliseconds{1}), Overrun::error), with(thread(milliseconds{4}), Overrun::error)});
  EXPECT_THAT(cycle(), ElementsAre("0:0", "1:0"));
  EXPECT_THAT(cycle(microseconds{2'500}), IsEmpty()) << "slot 3";
  EXPECT_EQ(error(0), ErrorType::overrun);
  EXPECT_EQ(device->blocks[0].error_text.view(), "2 releases were missed, from number 1 on");
  EXPECT_EQ(device->blocks[0].error_cycle.load(), 1U);
  EXPECT_EQ(missed(0), 2U);
  EXPECT_EQ(error(1), ErrorType::none) << "it missed no release";
  EXPECT_THAT(cycle(), ElementsAre("1:1"));
}

TEST_F(OverrunContract, ErrorRemovesAModuleThatEndsAfterItsNextRelease) {
  for (const Overrun contract : {Overrun::error, Overrun::stop_device}) {
    make({with(thread(milliseconds{1}), contract), thread(milliseconds{1})});
    takes = {milliseconds{1}, Nanoseconds{0}};
    EXPECT_THAT(cycle(), ElementsAre("0:0", "1:0"));
    EXPECT_EQ(error(0), ErrorType::none) << "it ended exactly at its next release";
    takes[0] = milliseconds{1} + Nanoseconds{1};
    EXPECT_THAT(cycle(), ElementsAre("0:1", "1:1"));
    EXPECT_EQ(error(0), ErrorType::overrun);
    EXPECT_EQ(device->blocks[0].error_text.view(), "run() ended after the module's next release");
    EXPECT_EQ(overruns(0), 1U);
    EXPECT_EQ(overruns(1), 1U) << "it ended late too, but its contract allows that";
    EXPECT_EQ(error(1), ErrorType::none);
  }
}

TEST_F(OverrunContract, AppliesToAProgramStillInItsBody) {
  make({process(milliseconds{1}), with(process(milliseconds{1}), Overrun::error),
        with(process(milliseconds{1}), Overrun::catch_up, 2)});
  for (int row = 0; row < 5; ++row) device->cycle();
  EXPECT_EQ(overruns(0), 4U);
  EXPECT_EQ(error(0), ErrorType::none);
  EXPECT_EQ(overruns(1), 1U);
  EXPECT_EQ(error(1), ErrorType::overrun);

  // Two releases of the third module, those at 3 and 4 ms, are pending.
  channel::ReleaseSlot& release_slot = device->slots[2];
  EXPECT_EQ(device->blocks[2].cycles.load(), 3U);
  EXPECT_EQ(overruns(2), 4U);
  EXPECT_EQ(release_slot.released.load(), 3U);
  release_slot.t0_ns.store(to_ns(device->t0));
  std::uint32_t done = 1;
  for (const std::uint64_t cycle : {3U, 4U}) {
    release_slot.done.store(done);
    const channel::Taken taken = channel::take(release_slot, done);
    EXPECT_EQ(taken.count, done + 1);
    EXPECT_EQ(taken.cycle, cycle);
    EXPECT_EQ(taken.release_ns, to_ns(device->t0 + milliseconds{cycle}));
    done = taken.count;
  }
  release_slot.done.store(done);
  EXPECT_TRUE(release_slot.waiting());
  device->cycle();
  EXPECT_EQ(channel::take(release_slot, done).cycle, 5U);
  EXPECT_EQ(device->blocks[2].cycles.load() + overruns(2) - 2, 6U) << "two of its overruns were served";
}

class Budget : public OverrunContract {
 protected:
  void make_with(model::BudgetTolerance tolerance) {
    model::Module module = thread(milliseconds{1});
    module.budget = microseconds{100};
    module.tolerance = tolerance;
    make({module});
  }
  /// Runs the module once for this time. Returns true if the run raised an error.
  bool is_error(int us) { return is_error(microseconds{us}); }
  bool is_error(Nanoseconds takes_now) {
    takes[0] = takes_now;
    cycle();
    const bool is = error(0) != ErrorType::none;
    if (is) {
      EXPECT_EQ(error(0), ErrorType::budget);
      device->blocks[0].error.store(0);
      device->blocks[0].in_tables.store(1);
    }
    return is;
  }
};

TEST_F(Budget, RaisesAnErrorOnAnyExcessWithoutATolerance) {
  make_with({});
  EXPECT_FALSE(is_error(100));
  EXPECT_TRUE(is_error(101));
  EXPECT_EQ(device->blocks[0].error_text.view(), "one run() took 101 us, longer than its budget");
  EXPECT_EQ(device->blocks[0].over_budget.load(), 1U);
  EXPECT_TRUE(is_error(1300));
  EXPECT_EQ(device->blocks[0].error_text.view(), "one run() took 1.3 ms, longer than its budget");
  EXPECT_TRUE(is_error(Nanoseconds{1'300'001}));
  EXPECT_EQ(device->blocks[0].error_text.view(), "one run() took 1.301 ms, longer than its budget");
}

TEST_F(Budget, ToleratesAnExcessUpToAMultipleOfTheBudget) {
  make_with({.times = 3, .in_a_row = {}});
  for (int i = 0; i < 10; ++i) EXPECT_FALSE(is_error(300));
  EXPECT_TRUE(is_error(301));
  EXPECT_EQ(device->blocks[0].error_text.view(), "one run() took 301 us, longer than 3 times its budget");
  EXPECT_EQ(device->blocks[0].over_budget.load(), 11U);
}

TEST_F(Budget, ToleratesFewerExcessesInARowThanTheLimit) {
  make_with({.times = {}, .in_a_row = 3});
  EXPECT_FALSE(is_error(900));
  EXPECT_FALSE(is_error(101));
  EXPECT_FALSE(is_error(100)) << "a run within the budget ends the series";
  EXPECT_FALSE(is_error(101));
  EXPECT_FALSE(is_error(101));
  EXPECT_TRUE(is_error(101));
  EXPECT_EQ(device->blocks[0].error_text.view(),
            "the last of 3 runs in a row took 101 us, longer than its budget");
  EXPECT_FALSE(is_error(101)) << "the count starts again";
}

TEST_F(Budget, ToleratesOnlyWhatBothLimitsAllow) {
  make_with({.times = 2, .in_a_row = 2});
  EXPECT_FALSE(is_error(200));
  EXPECT_TRUE(is_error(101));
  EXPECT_TRUE(is_error(201));
}

}  // namespace
}  // namespace takt::executor::overrun_test
