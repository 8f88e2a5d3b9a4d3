// The supervision's time limits.
#pragma once

#include <algorithm>
#include <cstddef>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::supervision {

/// The longest time that the call of a hook may take.
inline constexpr Nanoseconds kHookLimit = std::chrono::seconds{5};
/// The longest time from a program's start to its first waitPeriod() or waitSporadic().
inline constexpr Nanoseconds kAttachLimit = std::chrono::seconds{5};
/// How long the node waits for a program to end after it set the flag that ends the program's wait, and again
/// after SIGTERM. Then it sends SIGKILL.
inline constexpr Nanoseconds kProcessEndLimit = std::chrono::seconds{1};
/// How long the executors' threads may take to end their row.
inline constexpr Nanoseconds kHaltLimit = std::chrono::seconds{2};
/// How long a host may take to end after it was told to end.
inline constexpr Nanoseconds kHostEndLimit = std::chrono::seconds{2};
/// How long a device that has ended may take to write its last files: traces, and the state that its modules
/// retain.
inline constexpr Nanoseconds kWrittenWithin = std::chrono::seconds{3};
/// How often, within kRestartWindow, a host is restarted that ended without a module at fault. After that,
/// the node gives up the host or shuts down the device.
inline constexpr std::size_t kHostRestarts = 3;
inline constexpr Nanoseconds kRestartWindow = std::chrono::seconds{60};
/// The time between the restoration of a deployment and its first row.
inline constexpr Nanoseconds kJoinGridAhead = std::chrono::milliseconds{100};
/// How long a command to a module may take to complete.
inline constexpr Nanoseconds kCommandLimit = std::chrono::seconds{15};
/// How long a start command waits for the first row that names the module. A later row is not a failure: the
/// module may be sporadic or have a long period.
inline constexpr Nanoseconds kNamedWithin = std::chrono::milliseconds{500};
/// The interval at which the ports are checked for entries in the fault record.
inline constexpr Nanoseconds kPortsEvery = std::chrono::milliseconds{100};

/// A run() or a body that takes longer than this counts as hanging.
inline Nanoseconds stuck_after(const model::Module& module) {
  const Nanoseconds own = module.period ? *module.period : module.deadline.value_or(Nanoseconds{0});
  return std::chrono::seconds{1} + std::min<Nanoseconds>(10 * own, std::chrono::seconds{60});
}

}  // namespace takt::supervision
