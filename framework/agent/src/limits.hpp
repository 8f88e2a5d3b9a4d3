// The agent's time limits.
#pragma once

#include <cstddef>

#include <takt/core/time.hpp>

namespace takt::agent {

/// A node from which nothing arrives for this time is lost. The same as the lease of its status
/// (dds/topics.cpp).
inline constexpr Nanoseconds kLease = std::chrono::milliseconds{300};
/// The longest time that a prepared device searches for the other devices of its cell.
inline constexpr Nanoseconds kOthersFound = std::chrono::seconds{10};
/// The longest time that the connections between the ports of prepared devices may take.
inline constexpr Nanoseconds kConnected = std::chrono::seconds{10};
/// The largest difference between the wall clocks of two devices of a cell. A service that sets the clock
/// over the network (chrony, ptp4l, systemd-timesyncd) keeps clocks much closer than this; a clock that no
/// service sets soon differs by more than this.
inline constexpr Nanoseconds kClocksDiffer = std::chrono::milliseconds{100};
/// If a prepared device hears nothing from the operator for this time, its status says when it undoes what it
/// has prepared. The operator sends a request every 4 s.
inline constexpr Nanoseconds kSoonSilent = std::chrono::seconds{5};
/// A node that `takt run` started waits, before it ends, until `takt run` has received the final report, but
/// at most for this time.
inline constexpr Nanoseconds kReportFetched = std::chrono::seconds{2};
/// A node that has run for less than this time may not have discovered the other nodes of its domain yet.
inline constexpr Nanoseconds kFindsOthers = std::chrono::seconds{1};
/// How long a restarted node looks for another node with its device name before it restores its deployment. A
/// node finds the others more slowly with DDS Security.
inline constexpr Nanoseconds kTwinFound = std::chrono::milliseconds{300};
inline constexpr Nanoseconds kTwinFoundSecured = kFindsOthers;
/// A node with the same device name that is alive for longer than this is not the remains of a dead node,
/// because their lease of 300 ms would have ended.
inline constexpr Nanoseconds kRemains = std::chrono::seconds{1};
/// If a live node with the same device name is gone, a node that waits to restore its deployment waits for
/// this time in addition. So it does not take the other's place during a short loss of the network.
inline constexpr Nanoseconds kTwinBack = std::chrono::seconds{10};
/// If two nodes with one device name have executed without interruption for the same number of seconds, give
/// or take kSameAge, the ids of the nodes decide after kSameAge.
inline constexpr std::chrono::seconds kSameAge{2};
/// The longest time that one request keeps a tap of a port open; a further request extends this time.
inline constexpr Nanoseconds kLongestTap = std::chrono::seconds{60};
/// The longest time for which an operator can force an input.
inline constexpr Nanoseconds kLongestForce = std::chrono::hours{1};
/// How many undeployed deployments the agent remembers, so that a device that missed the undeploy command can
/// still learn of it.
inline constexpr std::size_t kUndeployedKept = 64;
/// The time between two attempts to write a file that could not be written.
inline constexpr Nanoseconds kDiskTriedEvery = std::chrono::seconds{5};
/// The time between two publications of the statistics.
inline constexpr Nanoseconds kMeasuresEvery = std::chrono::seconds{1};

}  // namespace takt::agent
