// The size of a device's flight record.
#pragma once

#include <cstdint>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::flight {

/// The time that the record covers.
inline constexpr Nanoseconds kKept = std::chrono::seconds{5};
/// The largest number of bytes for all rings of a device.
inline constexpr std::uint64_t kMostBytes = 16 * 1024 * 1024;

/// Returns the number of entries of each ring (channel::FlightRecord) for this time, as powers of two. It
/// assumes two entries per row, and four entries per run for the run and the samples that it writes. It
/// assumes that a sporadic module runs once per row. If the device needs more than kMostBytes, all rings are
/// reduced by the same factor.
std::vector<std::uint64_t> entries_for(const schedule::DevicePlan& plan, Nanoseconds kept = kKept);

}  // namespace takt::flight
