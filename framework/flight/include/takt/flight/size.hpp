// How many entries a device's record has room for.
#pragma once

#include <cstdint>
#include <vector>

#include <takt/core/time.hpp>
#include <takt/schedule/plan.hpp>

namespace takt::flight {

/// What is kept.
inline constexpr Nanoseconds kKept = std::chrono::seconds{5};
/// All rings of a device, in bytes.
inline constexpr std::uint64_t kMostBytes = 16 * 1024 * 1024;

/// Of each ring (channel::FlightRecord), for that long: two entries a row and four a run, a run and what it
/// writes; a sporadic module as often as a row may release it. Less where the device would need more than
/// kMostBytes bytes: each executor the same time then. Powers of two.
std::vector<std::uint64_t> entries_for(const schedule::DevicePlan& plan, Nanoseconds kept = kKept);

}  // namespace takt::flight
