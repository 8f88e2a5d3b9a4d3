// The supervision's time limits.
#pragma once

#include <algorithm>
#include <cstddef>

#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::supervision {

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
/// How far ahead the first row of a restored deployment lies.
inline constexpr Nanoseconds kJoinGridAhead = std::chrono::milliseconds{100};
/// The time for a command to a module to complete.
inline constexpr Nanoseconds kCommandLimit = std::chrono::seconds{15};
/// How long a start command waits for the first row that names the module. Later is not a failure: the module
/// may be sporadic or have a long period.
inline constexpr Nanoseconds kNamedWithin = std::chrono::milliseconds{500};
/// The interval of checks of the ports for the fault record.
inline constexpr Nanoseconds kPortsEvery = std::chrono::milliseconds{100};

/// A run() or a body that takes longer than this counts as hanging.
inline Nanoseconds stuck_after(const model::Module& module) {
  const Nanoseconds own = module.period ? *module.period : module.deadline.value_or(Nanoseconds{0});
  return std::chrono::seconds{1} + std::min<Nanoseconds>(10 * own, std::chrono::seconds{60});
}

}  // namespace takt::supervision
