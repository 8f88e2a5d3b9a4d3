#include <gtest/gtest.h>

#include <string>

#include "fake_device.hpp"

namespace takt::executor::error_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

class Error : public testing::Test {
 protected:
  Error() {
    model::Module limited = thread(milliseconds{1}, 2);
    limited.budget = microseconds{100};
    device = std::make_unique<FakeDevice>(
        std::vector<model::Module>{thread(milliseconds{1}, 1), limited, thread(milliseconds{1}, 3)});
    device->bodies[1].on_run = [this](const Cycle&) {
      device->clock.time += takes;
      return failure;
    };
    device->join();
  }

  std::unique_ptr<FakeDevice> device;
  Nanoseconds takes{};
  const char* failure = nullptr;
};

TEST_F(Error, RemovesTheModuleFromTheTablesWithinTheSameRow) {
  device->cycle();
  device->cycle();
  failure = "no answer from the drive";
  device->bodies[2].on_run = [this](const Cycle&) {
    EXPECT_EQ(device->blocks[1].in_tables.load(), 0U);
    EXPECT_EQ(device->blocks[1].error.load(), static_cast<std::uint32_t>(ErrorType::failure));
    return nullptr;
  };
  device->cycle();
  device->cycle();

  const channel::ModuleBlock& block = device->blocks[1];
  EXPECT_EQ(block.error_text.view(), "no answer from the drive");
  EXPECT_EQ(block.error_cycle.load(), 2U);
  EXPECT_EQ(block.errors.load(), 1U);
  EXPECT_EQ(block.cycles.load(), 3U) << "the failed call counts";
  EXPECT_EQ(block.run.read().count, 3U);
  for (std::size_t other : {0U, 2U}) {
    EXPECT_EQ(device->blocks[other].cycles.load(), 4U);
    EXPECT_EQ(device->blocks[other].errors.load(), 0U);
    EXPECT_EQ(device->blocks[other].in_tables.load(), 1U);
  }
}

TEST_F(Error, KeepsTheFirst255BytesOfItsText) {
  const std::string text(1000, 'x');
  failure = text.c_str();
  device->cycle();
  EXPECT_EQ(device->blocks[1].error_text.view(), std::string(255, 'x'));
}

TEST_F(Error, IsRaisedByARunOneNanosecondOverItsBudget) {
  takes = microseconds{100};
  device->cycle();
  EXPECT_EQ(device->blocks[1].error.load(), 0U);
  takes += Nanoseconds{1};
  device->cycle();
  EXPECT_EQ(device->blocks[1].error.load(), static_cast<std::uint32_t>(ErrorType::budget));
  EXPECT_EQ(device->blocks[1].error_text.view(), "one run() took 100.001 us, longer than its budget");
  EXPECT_EQ(device->blocks[1].error_cycle.load(), 1U);
  EXPECT_EQ(device->blocks[1].in_tables.load(), 0U);
  EXPECT_EQ(device->blocks[2].cycles.load(), 2U);
}

TEST_F(Error, IsNotRaisedByALateStartOfARunWithinItsBudget) {
  takes = microseconds{100};
  device->cycle(microseconds{600});
  EXPECT_EQ(device->blocks[1].error.load(), 0U);
}

TEST_F(Error, IsOfTypeFailureIfTheRunBothFailsAndExceedsItsBudget) {
  takes = microseconds{500};
  failure = "gave up";
  device->cycle();
  EXPECT_EQ(device->blocks[1].error.load(), static_cast<std::uint32_t>(ErrorType::failure));
  EXPECT_EQ(device->blocks[1].errors.load(), 1U);
}

TEST_F(Error, DoesNotShiftTheReleasesOfTheModuleAfterRecovery) {
  failure = "once";
  device->cycle();
  failure = nullptr;
  device->cycle();
  device->blocks[1].error.store(0);
  device->blocks[1].in_tables.store(1);
  std::uint64_t number = 0;
  device->bodies[1].on_run = [&number](const Cycle& cycle) {
    number = cycle.number;
    return nullptr;
  };
  device->cycle();
  EXPECT_EQ(number, 2U);
  EXPECT_EQ(device->blocks[1].cycles.load(), 2U);
  EXPECT_EQ(device->blocks[1].missed.load(), 0U)
      << "a row while it is out of the tables does not count as missed";
}

TEST_F(Error, IsNotRaisedByAnOverrunAlone) {
  device->bodies[0].on_run = [this](const Cycle&) {
    device->clock.time += milliseconds{4};
    return nullptr;
  };
  for (int i = 0; i < 3; ++i) device->cycle();
  EXPECT_EQ(device->blocks[0].overruns.load(), 3U);
  EXPECT_EQ(device->blocks[0].in_tables.load(), 1U);
  EXPECT_EQ(device->blocks[0].missed.load(), 6U);
}

}  // namespace
}  // namespace takt::executor::error_test
