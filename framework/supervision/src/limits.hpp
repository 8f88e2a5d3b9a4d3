// The supervision's time limits.
#pragma once

#include <algorithm>
#include <cstddef>

#include <takt/core/time.hpp>

namespace takt::supervision {

/// The longest time that the call of a hook may take.
inline constexpr Nanoseconds kHookLimit = std::chrono::seconds{5};
/// The longest time that a host may take to begin a hook that it was asked to call, or to answer after the
/// hook has returned.
inline constexpr Nanoseconds kAnswerLimit = std::chrono::seconds{10};
/// The time that a hung thread may take to report its calls and to end its host. Then the node kills the
/// host.
inline constexpr Nanoseconds kCallsLimit = std::chrono::milliseconds{100};
/// The same time while the device stops, when no other module waits for this host. The hung thread may have
/// no real-time priority and wait long for a CPU.
inline constexpr Nanoseconds kCallsLimitAtStop = std::chrono::seconds{1};
/// The longest time from the start of a process module to its first waitPeriod() or waitSporadic().
inline constexpr Nanoseconds kAttachLimit = std::chrono::seconds{5};
/// The time that the node waits for a process module to end before it uses a stronger means. The node first
/// sets the flag that ends the module's wait for releases, then sends SIGTERM, and finally SIGKILL.
inline constexpr Nanoseconds kProcessEndLimit = std::chrono::seconds{1};
/// A force of an input ends if its client does not renew it within this time.
inline constexpr Nanoseconds kForceLease = std::chrono::seconds{2};
/// The time that a program may take to get or set a property of its own.
inline constexpr Nanoseconds kPropertyLimit = std::chrono::seconds{2};
/// The time that the executors' threads may take to end their row after they were told to halt.
inline constexpr Nanoseconds kHaltLimit = std::chrono::seconds{2};
/// The time that a host may take to end after it was told to end.
inline constexpr Nanoseconds kHostEndLimit = std::chrono::seconds{2};
/// The time that a device that has ended may take to write its last files: traces, and the state that its
/// modules retain.
inline constexpr Nanoseconds kWrittenWithin = std::chrono::seconds{3};
/// The number of times within kRestartWindow that the node restarts a host that ended although no module was
/// at fault. If the host ends once more, the node gives up the host or shuts down the device.
inline constexpr std::size_t kHostRestarts = 3;
inline constexpr Nanoseconds kRestartWindow = std::chrono::seconds{60};
/// The time between the restoration of a deployment and its first row.
inline constexpr Nanoseconds kJoinGridAhead = std::chrono::milliseconds{100};
/// The time that a command to a module may take to complete.
inline constexpr Nanoseconds kCommandLimit = std::chrono::seconds{15};
/// If the first row that contains the module may come later than this time, a start command waits only for
/// this time, and then succeeds before that row.
inline constexpr Nanoseconds kNamedWithin = std::chrono::milliseconds{500};
/// The interval at which the ports are checked for entries in the fault record.
inline constexpr Nanoseconds kPortsEvery = std::chrono::milliseconds{100};
/// If the time between two steps of the supervision is longer than this, the node was stopped or the machine
/// stood still. Every other process probably stood still, too. The steps of a node whose CPU is kept busy by
/// a real-time thread come up to 1 s late, because the kernel gives the node only 50 ms of each second.
inline constexpr Nanoseconds kStoodStill = std::chrono::seconds{2};
/// A run or a body that has lasted this long may keep other threads from their CPU.
inline constexpr Nanoseconds kLongRun = std::chrono::milliseconds{20};

/// An executor or a module whose number of cycles does not change for this time is in error. `period` is the
/// time between two of its cycles.
inline Nanoseconds stands_after(Nanoseconds period) {
  return std::chrono::seconds{1} + 10 * std::min<Nanoseconds>(period, std::chrono::hours{24 * 365});
}

}  // namespace takt::supervision
