// The size of a device's flight record.
#pragma once

#include <cstdint>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::flight {

/// The time that the record covers.
inline constexpr Nanoseconds kKept = std::chrono::seconds{5};
/// The most bytes for all rings of a device.
inline constexpr std::uint64_t kMostBytes = 16 * 1024 * 1024;

/// The number of entries of each ring (channel::FlightRecord) for this time, as powers of two. It counts two
/// entries per row and four per run (the run and what it writes); a sporadic module may run once per row. If
/// the device would need more than kMostBytes, every ring is reduced by the same factor.
std::vector<std::uint64_t> entries_for(const schedule::DevicePlan& plan, Nanoseconds kept = kKept);

}  // namespace takt::flight
