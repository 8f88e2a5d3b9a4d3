#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "fake_device.hpp"

namespace takt::executor::sporadic_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
constexpr auto kThread = model::ModuleType::thread;
constexpr auto kProcess = model::ModuleType::process;

const char* hold(bool* ready) {
  *ready = true;
  return nullptr;
}

class SporadicModule : public testing::Test {
 protected:
  /// Makes a device with one sporadic thread module for each deadline. Module 0 of the device is periodic,
  /// with a period of 1 ms.
  void make(const std::vector<Nanoseconds>& deadlines) {
    std::vector<model::Module> modules{thread(milliseconds{1})};
    for (const Nanoseconds deadline : deadlines) modules.push_back(sporadic(kThread, deadline));
    device = std::make_unique<FakeDevice>(modules);
    for (std::size_t i = 0; i < modules.size(); ++i) {
      device->bodies[i].on_run = [this, i](const Cycle&) {
        ran += std::to_string(i) + " ";
        return nullptr;
      };
    }
    device->join();
  }
  void run_all() {
    while (device->executor->run_sporadic()) {
    }
  }

  std::unique_ptr<FakeDevice> device;
  std::string ran;
};

TEST_F(SporadicModule, DoesNotRunUnlessItsConditionHolds) {
  make({milliseconds{5}});
  EXPECT_EQ(device->cycle(), 0U);
  EXPECT_FALSE(device->executor->run_sporadic());
  EXPECT_EQ(device->bodies[1].asked, 1);
  EXPECT_EQ(ran, "0 ");
}

TEST_F(SporadicModule, HasItsConditionCheckedOnlyAtTheEndOfARow) {
  make({milliseconds{5}});
  device->bodies[1].on_condition = [this](bool* ready) {
    ran += "? ";
    *ready = true;
    return nullptr;
  };
  EXPECT_FALSE(device->executor->run_sporadic());
  EXPECT_EQ(device->cycle(), channel::kSporadicBit);
  EXPECT_EQ(ran, "0 ? ") << "the sporadic thread runs it, not the row";
  EXPECT_TRUE(device->executor->run_sporadic());
  EXPECT_FALSE(device->executor->run_sporadic());
  EXPECT_EQ(ran, "0 ? 1 ");
  EXPECT_EQ(device->blocks[1].cycles.load(), 1U);
}

TEST_F(SporadicModule, GetsTheNumberAndTimeOfTheRowThatReleasedIt) {
  make({milliseconds{5}});
  Cycle seen;
  device->bodies[1].on_condition = hold;
  device->bodies[1].on_run = [&seen](const Cycle& cycle) {
    seen = cycle;
    return nullptr;
  };
  device->cycle();
  run_all();
  device->cycle(microseconds{10});
  device->clock.time += milliseconds{3};
  run_all();
  EXPECT_EQ(seen.number, 1U);
  EXPECT_EQ(seen.time, device->t0 + milliseconds{1});
  EXPECT_EQ(seen.period, milliseconds{1});
}

TEST_F(SporadicModule, RunsFirstIfItsAbsoluteDeadlineIsEarliest) {
  make({milliseconds{9}, milliseconds{3}, milliseconds{6}});
  device->bodies[1].on_condition = hold;
  device->cycle();  // the deadline of module 1 is at 9 ms
  device->cycle();
  device->cycle();
  device->cycle();
  device->bodies[2].on_condition = hold;
  device->bodies[3].on_condition = hold;
  device->cycle();  // releases modules 2 and 3 at 4 ms; their deadlines are at 7 and 10 ms
  ran.clear();
  while (device->executor->run_sporadic()) {
    device->bodies[2].on_condition = nullptr;
  }
  EXPECT_EQ(ran, "2 1 3 ");
}

TEST_F(SporadicModule, RunsInTableOrderIfDeadlinesAreEqual) {
  std::vector<model::Module> modules{thread(milliseconds{1}), sporadic(kThread, milliseconds{5}, 7),
                                     sporadic(kThread, milliseconds{5}, 3),
                                     sporadic(kThread, milliseconds{5}, 7)};
  FakeDevice fake{modules};
  for (std::size_t i = 1; i < 4; ++i) {
    fake.bodies[i].on_condition = hold;
    fake.bodies[i].on_run = [this, i](const Cycle&) {
      ran += std::to_string(i) + " ";
      return nullptr;
    };
  }
  fake.join();
  fake.cycle();
  while (fake.executor->run_sporadic()) {
  }
  EXPECT_EQ(ran, "2 1 3 ") << "by priority, then by position in the file";
}

TEST_F(SporadicModule, HasItsConditionCheckedOnlyOnceUntilItRuns) {
  make({milliseconds{5}});
  device->bodies[1].on_condition = hold;
  EXPECT_EQ(device->cycle(), channel::kSporadicBit);
  EXPECT_EQ(device->cycle(), 0U) << "the wake word is set once";
  device->cycle();
  EXPECT_EQ(device->bodies[1].asked, 1);
  run_all();
  EXPECT_EQ(device->cycle(), channel::kSporadicBit);
  EXPECT_EQ(device->bodies[1].asked, 2);
  EXPECT_EQ(device->blocks[1].cycles.load(), 1U);
}

TEST_F(SporadicModule, IsNotCheckedByARowThatPreemptsIt) {
  make({milliseconds{5}});
  device->bodies[1].on_condition = hold;
  device->bodies[1].on_run = [this](const Cycle&) {
    device->clock.time += milliseconds{1};
    EXPECT_EQ(device->cycle(), 0U);  // this row preempts the sporadic run
    return nullptr;
  };
  device->cycle();
  run_all();
  EXPECT_EQ(device->bodies[1].asked, 1);
  EXPECT_EQ(device->blocks[0].cycles.load(), 2U);
  EXPECT_EQ(device->block->sporadic.module.load(), 0U);
}

TEST_F(SporadicModule, CountsAnOverrunIfItEndsAfterItsDeadline) {
  make({milliseconds{5}});
  device->bodies[1].on_condition = hold;
  Nanoseconds takes = milliseconds{5} - microseconds{20};
  device->bodies[1].on_run = [&](const Cycle&) {
    device->clock.time += takes;
    return nullptr;
  };
  device->cycle(microseconds{20});
  run_all();  // the run ends at the deadline, which counts from the release
  EXPECT_EQ(device->blocks[1].overruns.load(), 0U);

  takes += Nanoseconds{1};
  device->cycle(microseconds{20});
  run_all();
  EXPECT_EQ(device->blocks[1].overruns.load(), 1U);
  EXPECT_EQ(device->blocks[1].cycles.load(), 2U);
  EXPECT_EQ(device->blocks[1].errors.load(), 0U);
}

TEST_F(SporadicModule, IsRemovedAfterAnErrorInItsCondition) {
  make({milliseconds{5}, milliseconds{5}});
  device->bodies[1].on_condition = [](bool* ready) {
    *ready = true;
    return "the sensor is gone";
  };
  device->bodies[2].on_condition = hold;
  device->cycle();
  device->cycle();
  run_all();
  EXPECT_EQ(ran, "0 0 2 ");
  const channel::ModuleBlock& block = device->blocks[1];
  EXPECT_EQ(device->bodies[1].asked, 1);
  EXPECT_EQ(block.in_tables.load(), 0U);
  EXPECT_EQ(block.error.load(), static_cast<std::uint32_t>(ErrorType::failure));
  EXPECT_EQ(block.error_text.view(), "the sensor is gone");
  EXPECT_EQ(block.error_cycle.load(), 0U);
  EXPECT_EQ(block.errors.load(), 1U);
}

TEST_F(SporadicModule, DoesNotRunAfterItsRemoval) {
  make({milliseconds{5}});
  device->bodies[1].on_condition = hold;
  device->cycle();
  device->blocks[1].in_tables.store(0);
  EXPECT_TRUE(device->executor->run_sporadic()) << "the module was still ready";
  EXPECT_EQ(ran, "0 ");
  EXPECT_EQ(device->blocks[1].cycles.load(), 0U);
  device->cycle();
  EXPECT_EQ(device->bodies[1].asked, 1) << "the condition is not checked out of the tables";

  device->blocks[1].in_tables.store(1);
  device->cycle();
  run_all();
  EXPECT_EQ(ran, "0 0 0 1 ");
}

TEST_F(SporadicModule, IsRemovedIfItExceedsItsBudget) {
  model::Module module = sporadic(kThread, milliseconds{5});
  module.budget = microseconds{100};
  FakeDevice fake{{thread(milliseconds{1}), module}};
  fake.bodies[1].on_condition = hold;
  fake.bodies[1].on_run = [&fake](const Cycle&) {
    fake.clock.time += microseconds{101};
    return nullptr;
  };
  fake.join();
  fake.cycle();
  fake.executor->run_sporadic();
  EXPECT_EQ(fake.blocks[1].error.load(), static_cast<std::uint32_t>(ErrorType::budget));
  EXPECT_EQ(fake.blocks[1].in_tables.load(), 0U);
}

TEST_F(SporadicModule, IsReleasedByEveryRowIfItIsAWaitingProgram) {
  FakeDevice fake{{sporadic(kProcess, milliseconds{10})}};
  channel::ReleaseSlot& slot = fake.slots[0];
  fake.join();
  fake.cycle();
  EXPECT_EQ(slot.released.load(), 1U);
  EXPECT_EQ(slot.cycle(slot.released.load()), 0U);
  fake.cycle();  // in this row, the program is still in its body
  EXPECT_EQ(slot.released.load(), 1U);
  slot.done.store(1);
  fake.cycle();
  EXPECT_EQ(slot.released.load(), 2U);
  EXPECT_EQ(slot.cycle(slot.released.load()), 2U);
  EXPECT_EQ(fake.blocks[0].cycles.load(), 2U);
  EXPECT_EQ(fake.blocks[0].overruns.load(), 0U);
}

}  // namespace
}  // namespace takt::executor::sporadic_test
