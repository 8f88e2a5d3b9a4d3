#include <takt/flight/size.hpp>

#include <algorithm>

#include <takt/channel/flight.hpp>

namespace takt::flight {

namespace {

constexpr std::uint64_t kLeast = 1024;
constexpr double kPerRow = 2;
constexpr double kPerRun = 4;

std::uint64_t power_of_two(double entries) {
  std::uint64_t capacity = kLeast;
  while (static_cast<double>(capacity) < entries && capacity < (std::uint64_t{1} << 32)) capacity *= 2;
  return capacity;
}

}  // namespace

std::vector<std::uint64_t> entries_for(const schedule::DevicePlan& plan, Nanoseconds kept) {
  std::vector<std::uint64_t> entries;
  for (const schedule::ExecutorPlan& executor : plan.executors) {
    if (executor.basic_period <= Nanoseconds{0}) {
      entries.insert(entries.end(), 2, 0);
      continue;
    }
    const double rows =
        static_cast<double>(kept.count()) / static_cast<double>(executor.basic_period.count());
    const std::size_t length = executor.table.rows();
    const double runs =
        length == 0 ? 0 : rows * static_cast<double>(executor.table.entries()) / static_cast<double>(length);
    const double sporadic = rows * static_cast<double>(executor.sporadic.size());
    entries.push_back(power_of_two(rows * kPerRow + runs * kPerRun + sporadic));
    entries.push_back(executor.sporadic.empty() ? 0 : power_of_two(sporadic * kPerRun));
  }
  const auto bytes = [&entries] {
    std::uint64_t sum = 0;
    for (const std::uint64_t each : entries) sum += each * sizeof(channel::FlightEntry);
    return sum;
  };
  while (bytes() > kMostBytes) {
    for (std::uint64_t& each : entries) each = each > 1 ? each / 2 : each;
  }
  return entries;
}

}  // namespace takt::flight
