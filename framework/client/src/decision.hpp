// How the devices of a cell decide about a deployment or an update after the operator has sent them T0.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include <takt/client/observer.hpp>
#include <takt/core/time.hpp>

namespace takt::client {

/// Returns a T0 on the wall clock, in ns since 1970. It lies the further ahead, the longer the devices took
/// for the command before, `took`.
std::int64_t choose_t0(Nanoseconds took);
/// Returns how long the devices may take to confirm T0. If a device does not confirm in time, the operator
/// can still cancel before T0.
std::chrono::milliseconds time_to_confirm(std::int64_t t0_ns);

/// A deployment or update about which the devices decide.
struct Undecided {
  std::string id;          ///< id of the deployment or update
  std::string deployment;  ///< id of the deployment; an undeployed device has undone it
  std::int64_t t0_ns = 0;
};

enum class Stands {
  final,
  undone,
  undecided,
  lost,
};

/// Waits until each of these devices is final, or until one of them has undone the deployment or update; at
/// most some seconds after T0. Returns what is then known of each device.
std::vector<Stands> wait_until_decided(const Observer& observer, const std::vector<std::string>& devices,
                                       const Undecided& what, const std::function<bool()>& cancelled);

}  // namespace takt::client
