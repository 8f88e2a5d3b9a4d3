// The node's time limits.
#pragma once

#include <algorithm>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::node {

/// The longest call of a hook.
inline constexpr Nanoseconds kHookLimit = std::chrono::seconds{5};
/// The longest time from a program's start to its first waitPeriod() or waitSporadic().
inline constexpr Nanoseconds kAttachLimit = std::chrono::seconds{5};
/// The limit for each step of ending a program: return to its wait, SIGTERM, SIGKILL.
inline constexpr Nanoseconds kProcessEndLimit = std::chrono::seconds{1};
/// The time for the executors' threads to end their row.
inline constexpr Nanoseconds kHaltLimit = std::chrono::seconds{2};
/// The time for a host to end after it was told to.
inline constexpr Nanoseconds kHostEndLimit = std::chrono::seconds{2};
/// The time for a device that has ended to write its last files: traces, and what its modules retain.
inline constexpr Nanoseconds kWrittenWithin = std::chrono::seconds{3};
/// How often a host that ends without a module at fault is restarted in kRestartWindow. After that the node
/// gives up the host, or ends the device.
inline constexpr std::size_t kHostRestarts = 3;
inline constexpr Nanoseconds kRestartWindow = std::chrono::seconds{60};

/// How long a prepared deployment, or an update, waits for its client's next message before it is undone.
inline constexpr Nanoseconds kRunAwaited = std::chrono::seconds{20};
/// How far ahead the first row of a restored deployment lies.
inline constexpr Nanoseconds kJoinGridAhead = std::chrono::milliseconds{100};
/// How far ahead T0 may lie.
inline constexpr Nanoseconds kFurthestStart = std::chrono::seconds{60};
/// How long a node that takt run started waits, before it ends, for its final report to be fetched.
inline constexpr Nanoseconds kReportFetched = std::chrono::seconds{2};
/// The time for a command to a module to complete.
inline constexpr Nanoseconds kCommandLimit = std::chrono::seconds{15};
/// How long a start command waits for the first row that names the module. Later is not a failure: the module
/// may be sporadic or have a long period.
inline constexpr Nanoseconds kNamedWithin = std::chrono::milliseconds{500};
/// A node that has run for less than this may not have discovered the others of its domain yet.
inline constexpr Nanoseconds kFindsOthers = std::chrono::seconds{1};
/// The longest time that one request keeps a tap of a port open; another request extends it.
inline constexpr Nanoseconds kLongestTap = std::chrono::seconds{60};
/// The interval of checks of the ports for the fault record.
inline constexpr Nanoseconds kPortsEvery = std::chrono::milliseconds{100};
/// The interval of attempts to write a file that could not be written.
inline constexpr Nanoseconds kDiskTriedEvery = std::chrono::seconds{5};
/// The interval of published statistics.
inline constexpr Nanoseconds kMeasuresEvery = std::chrono::seconds{1};

/// A run() or a body that takes longer than this counts as hanging.
inline Nanoseconds stuck_after(const model::Module& module) {
  const Nanoseconds own = module.period ? *module.period : module.deadline.value_or(Nanoseconds{0});
  return std::chrono::seconds{1} + std::min<Nanoseconds>(10 * own, std::chrono::seconds{60});
}

}  // namespace takt::node
