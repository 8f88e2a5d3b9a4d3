#include <takt/flight/size.hpp>

#include <gtest/gtest.h>

#include <numeric>

#include <takt/channel/flight.hpp>
#include <takt/model/cell.hpp>

namespace takt::flight::size_test {
namespace {

using namespace std::chrono_literals;

schedule::DevicePlan plan_of(std::size_t modules, Nanoseconds period, std::size_t sporadic = 0) {
  model::Device device;
  device.executors.emplace_back();
  for (std::size_t i = 0; i < modules + sporadic; ++i) {
    model::Module module;
    module.name = "m" + std::to_string(i);
    module.executor = device.executors[0].name;
    if (i < modules) {
      module.period = period;
    } else {
      module.operation = model::Operation::sporadic;
      module.deadline = period;
    }
    device.modules.push_back(module);
  }
  return *schedule::plan(model::Cell{}, device);
}

std::uint64_t bytes(const std::vector<std::uint64_t>& entries) {
  return std::accumulate(entries.begin(), entries.end(), std::uint64_t{0}) * sizeof(channel::FlightEntry);
}

TEST(RecordingSize, CoversTheRequestedDuration) {
  // 5 s contain 5000 rows. Each row writes 2 entries, and 4 entries for each of its 10 runs: 210,000 in
  // total. The size is the next power of two.
  EXPECT_EQ(entries_for(plan_of(10, 1ms), 5s), (std::vector<std::uint64_t>{262'144, 0}));
}

TEST(RecordingSize, IsZeroForAnExecutorWithoutModules) {
  EXPECT_EQ(entries_for(plan_of(0, 1ms), 5s), (std::vector<std::uint64_t>{0, 0}));
}

TEST(RecordingSize, IncludesARingForSporadicModules) {
  const auto entries = entries_for(plan_of(1, 10ms, 2), 5s);
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_GE(entries[1], 500U * 2 * 4);
}

TEST(RecordingSize, NeverExceedsTheMemoryLimit) {
  for (const std::size_t modules : {1U, 10U, 1000U}) {
    for (const Nanoseconds period : {Nanoseconds{1}, Nanoseconds{1us}, Nanoseconds{50us}, Nanoseconds{1ms}}) {
      const auto entries = entries_for(plan_of(modules, period));
      EXPECT_LE(bytes(entries), kMostBytes);
      for (const std::uint64_t each : entries) EXPECT_EQ(each & (each - 1), 0U);
    }
  }
}

}  // namespace
}  // namespace takt::flight::size_test
