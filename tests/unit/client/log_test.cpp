#include <takt/client/log.hpp>

#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace takt::client::log_test {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

model::Fault event(const std::string& device, std::uint64_t sequence, std::int64_t time_ns) {
  model::Fault event;
  event.device = device;
  event.sequence = sequence;
  event.time_ns = time_ns;
  return event;
}

/// The sorted events, each as the first letter of its device and its sequence number.
std::vector<std::string> sorted(std::vector<model::Fault> events) {
  sort_by_time(events);
  std::vector<std::string> order;
  for (const model::Fault& each : events)
    order.push_back(each.device.substr(0, 1) + std::to_string(each.sequence));
  return order;
}

using Order = std::vector<std::string>;

TEST(LogOrder, FollowsTheTimesOfTheEventsOfAllDevices) {
  EXPECT_EQ(sorted({event("robot", 1, 10), event("robot", 2, 30), event("line", 1, 20)}),
            (Order{"r1", "l1", "r2"}));
}

TEST(LogOrder, UsesTheOwnTimeOfAnEventThatWasRecordedLate) {
  EXPECT_EQ(sorted({event("robot", 1, 10), event("robot", 2, kSecond), event("robot", 3, 20)}),
            (Order{"r1", "r3", "r2"}));
}

TEST(LogOrder, KeepsEventsWithEqualTimesInSequence) {
  EXPECT_EQ(sorted({event("robot", 2, 10), event("robot", 1, 10)}), (Order{"r1", "r2"}));
}

TEST(LogOrder, KeepsTheEventsOfADeviceInSequenceEvenIfItsClockIsSetBack) {
  const std::int64_t hour = 3600 * kSecond;
  EXPECT_EQ(sorted({event("robot", 1, hour), event("robot", 2, 0), event("robot", 3, kSecond),
                    event("robot", 4, -hour), event("robot", 5, 2 * hour), event("line", 1, hour + 1)}),
            (Order{"r1", "r2", "l1", "r3", "r4", "r5"}));
}

}  // namespace
}  // namespace takt::client::log_test
