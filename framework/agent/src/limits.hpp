// The agent's time limits.
#pragma once

#include <takt/core/time.hpp>

namespace takt::agent {

/// How long a prepared deployment, or an update, waits for its client's next message before it is undone.
inline constexpr Nanoseconds kRunAwaited = std::chrono::seconds{20};
/// How far in the future T0 may be.
inline constexpr Nanoseconds kFurthestStart = std::chrono::seconds{60};
/// How long a node that takt run started waits, before it ends, for its final report to be fetched.
inline constexpr Nanoseconds kReportFetched = std::chrono::seconds{2};
/// A node that has run for less than this may not have discovered the other nodes of its domain yet.
inline constexpr Nanoseconds kFindsOthers = std::chrono::seconds{1};
/// The longest time that one request keeps a tap of a port open; another request extends it.
inline constexpr Nanoseconds kLongestTap = std::chrono::seconds{60};
/// The interval of attempts to write a file that could not be written.
inline constexpr Nanoseconds kDiskTriedEvery = std::chrono::seconds{5};
/// The interval of published statistics.
inline constexpr Nanoseconds kMeasuresEvery = std::chrono::seconds{1};

}  // namespace takt::agent
