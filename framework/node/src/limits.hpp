// How long a node waits for what should not take long.
#pragma once

#include <algorithm>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::node {

/// One hook.
inline constexpr Nanoseconds kHookLimit = std::chrono::seconds{5};
/// A program, from its start to its first waitPeriod() or waitSporadic().
inline constexpr Nanoseconds kAttachLimit = std::chrono::seconds{5};
/// Each step of a program's end: leaving its wait, SIGTERM, SIGKILL.
inline constexpr Nanoseconds kProcessEndLimit = std::chrono::seconds{1};
/// The executors' threads, to end their row.
inline constexpr Nanoseconds kHaltLimit = std::chrono::seconds{2};
/// The host, to end when nothing is left to do.
inline constexpr Nanoseconds kHostEndLimit = std::chrono::seconds{2};
/// The last files of a device that has ended: what it did, and what its modules retain.
inline constexpr Nanoseconds kWrittenWithin = std::chrono::seconds{3};
/// A host that ends without a culprit is started again this often in kRestartWindow; then the device ends.
inline constexpr std::size_t kHostRestarts = 3;
inline constexpr Nanoseconds kRestartWindow = std::chrono::seconds{60};

/// A prepared deployment, to be told when it is to run, or that others are still being prepared; then it is
/// undone.
inline constexpr Nanoseconds kRunAwaited = std::chrono::seconds{20};
/// A deployment that is taken up again, to the first row that it walks.
inline constexpr Nanoseconds kJoinGridAhead = std::chrono::milliseconds{100};
/// How far ahead T0 may lie.
inline constexpr Nanoseconds kFurthestStart = std::chrono::seconds{60};
/// A node that was lent and is to end, for its closing report to be fetched.
inline constexpr Nanoseconds kReportFetched = std::chrono::seconds{2};
/// An order to a module, to come about.
inline constexpr Nanoseconds kCommandLimit = std::chrono::seconds{15};
/// A module that was started, to be named by a row; later is no failure: it is sporadic, or its period is
/// long.
inline constexpr Nanoseconds kNamedWithin = std::chrono::milliseconds{500};
/// A node that has run for less than this may not have discovered the others of its domain yet.
inline constexpr Nanoseconds kFindsOthers = std::chrono::seconds{1};
/// A port that somebody listens in on; longer when it is asked for again.
inline constexpr Nanoseconds kLongestTap = std::chrono::seconds{60};
/// Between two looks at ports for the fault record.
inline constexpr Nanoseconds kPortsEvery = std::chrono::milliseconds{100};
/// Between two attempts at a file that could not be written.
inline constexpr Nanoseconds kDiskTriedEvery = std::chrono::seconds{5};
/// Between two statistics of a module.
inline constexpr Nanoseconds kMeasuresEvery = std::chrono::seconds{1};

/// A run() or a body that takes longer than this is taken to be never coming back.
inline Nanoseconds stuck_after(const model::Module& module) {
  const Nanoseconds own = module.period ? *module.period : module.deadline.value_or(Nanoseconds{0});
  return std::chrono::seconds{1} + std::min<Nanoseconds>(10 * own, std::chrono::seconds{60});
}

}  // namespace takt::node
