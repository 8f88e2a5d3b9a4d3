// Deploys a cell to all of its devices or to none.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <takt/client/operator.hpp>
#include <takt/client/undeploy.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::client {

struct DeployOptions {
  /// The longest time that deploy() searches for the devices.
  Nanoseconds discovery = std::chrono::seconds{5};
  bool require_real_time = false;
  /// For each device whose node `takt run` started: the process id of this node. deploy() accepts no other
  /// node for the device.
  std::map<std::string, std::int32_t> process_ids;
  /// deploy() calls this function with a line of text that tells the user what deploy() is doing.
  std::function<void(const std::string&)> progress;
  /// deploy() calls this function repeatedly. If it returns true, deploy() undoes the deployment.
  std::function<bool()> cancelled;
  /// If not null: deploy() stores the answers of the devices here when it has undone a failed deployment. An
  /// answer with problems means that the state of this device is not known.
  std::vector<Undeployed>* undone = nullptr;
};

struct Deployed {
  std::string id;             ///< id of the deployment
  std::int64_t t0_ns = 0;     ///< T0, at which the devices start; wall clock, in ns since 1970
  Problems failed_modules{};  ///< modules that failed at once
};

/// Finds the devices, prepares all of them in parallel, starts all of them at the same instant, and waits
/// until each device has heard that all others run. If a device fails, undoes the deployment on all devices
/// and returns the problems of all devices. `text` is the descriptor from which `cell` was read.
Result<Deployed> deploy(Operator& sender, const model::Cell& cell, const std::string& text,
                        const DeployOptions& options);

}  // namespace takt::client
