// The size of a device's flight record.
#pragma once

#include <cstdint>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::flight {

/// The time that the flight record of a device should cover.
inline constexpr Nanoseconds kKept = std::chrono::seconds{5};
/// The maximum size of all rings of a device together, in bytes.
inline constexpr std::uint64_t kMostBytes = 16 * 1024 * 1024;

/// Returns the number of entries that each ring (channel::FlightRecord) needs to cover the time `kept`,
/// rounded up to a power of two. Assumes two entries for each row, four entries for each run (the run itself
/// and the samples that it writes), and one run of each sporadic module in each row. If the device needs more
/// than kMostBytes, all rings become smaller by the same factor.
std::vector<std::uint64_t> entries_for(const schedule::DevicePlan& plan, Nanoseconds kept = kKept);

}  // namespace takt::flight
