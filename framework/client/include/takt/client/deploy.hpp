// Deploys a cell to all of its devices or to none.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>

namespace takt::client {

/// What one device answered after its deployment had ended.
struct Undeployed {
  std::string device;
  Problems problems{};                  ///< why it could not be undeployed; empty if it was
  nlohmann::ordered_json report{};      ///< its object of the status JSON; null if it sent none
  std::vector<std::string> failures{};  ///< why the device or its modules failed
};

struct DeployOptions {
  /// How long to search for the devices.
  Nanoseconds discovery = std::chrono::seconds{5};
  /// The time from the moment when all devices are ready to T0, the instant at which they start.
  Nanoseconds lead = std::chrono::milliseconds{1000};
  /// The time before T0 at which each device must have confirmed T0. If a device has not, the deployment is
  /// undone on all devices in the time that remains.
  Nanoseconds margin = std::chrono::milliseconds{200};
  bool require_real_time = false;
  /// The process ids of the nodes of devices for which only this node may answer, because takt run started
  /// it.
  std::map<std::string, std::int32_t> process_ids;
  /// Called with one line for the user, which says what deploy() waits for.
  std::function<void(const std::string&)> progress;
  /// Polled until deploy() is done. If it returns true, the deployment is undone.
  std::function<bool()> cancelled;
  /// Receives the answer of each device when a failed deployment was undone.
  std::vector<Undeployed>* undone = nullptr;
};

struct Deployed {
  std::string id;          ///< id of the deployment
  std::int64_t t0_ns = 0;  ///< start of the deployment, on the wall clock
};

/// Finds the devices, prepares them all at the same time, and starts them all at one instant. If this fails,
/// undoes the deployment and returns the problems of all devices. `text` is the descriptor that `cell` was
/// read from.
Result<Deployed> deploy(Operator& asker, const model::Cell& cell, const std::string& text,
                        const DeployOptions& options);

/// Which devices to undeploy, and which deployment.
struct Devices {
  std::vector<std::string> names;
  std::map<std::string, std::int32_t> process_ids{};  ///< see DeployOptions
  std::string deployment{};                           ///< only this deployment; empty for any
};
/// Ends the deployment on all these devices at the same time. Waits until all have answered or are lost, and
/// calls `meanwhile` again and again while it waits.
std::vector<Undeployed> undeploy(Operator& asker, const Devices& devices,
                                 const std::function<void()>& meanwhile = {});

/// The devices of a cell.
struct CellDevices {
  std::vector<std::string> names{};  ///< devices that run the cell or still hold it
  std::vector<std::string> lost{};   ///< devices of the cell that other devices have lost
};
/// Finds the devices of a cell. Fails if no device has the cell; the problem lists the cells of the domain.
Result<CellDevices> devices_of(Operator& asker, const std::string& cell);

}  // namespace takt::client
