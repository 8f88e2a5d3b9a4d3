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

/// The answer of one device to the command to end its deployment.
struct Undeployed {
  std::string device;
  Problems problems{};                  ///< why the deployment could not be ended; empty if it has ended
  nlohmann::ordered_json report{};      ///< the device's object in the status JSON; null if the device sent
                                        ///< none
  std::vector<std::string> failures{};  ///< why the device or its modules failed
};

struct DeployOptions {
  /// How long to search for the devices.
  Nanoseconds discovery = std::chrono::seconds{5};
  /// The time between the moment when all devices are ready and T0, the instant at which they start.
  Nanoseconds lead = std::chrono::milliseconds{1000};
  /// Each device must confirm T0 at least this long before T0. If a device does not, the remaining time is
  /// used to undo the deployment on all devices.
  Nanoseconds margin = std::chrono::milliseconds{200};
  bool require_real_time = false;
  /// The process id of the node for each device whose node takt run started. No other node may answer for
  /// such a device.
  std::map<std::string, std::int32_t> process_ids;
  /// Called with one line for the user, which says what deploy() is doing.
  std::function<void(const std::string&)> progress;
  /// Called repeatedly until deploy() is done. If it returns true, deploy() undoes the deployment.
  std::function<bool()> cancelled;
  /// If not null, receives the answer of each device when deploy() has undone a failed deployment.
  std::vector<Undeployed>* undone = nullptr;
};

struct Deployed {
  std::string id;          ///< id of the deployment
  std::int64_t t0_ns = 0;  ///< T0, at which the devices start; wall clock, in ns since 1970
};

/// Finds the devices, prepares all of them in parallel, and starts all of them at the same instant. If a
/// device fails, undoes the deployment and returns the problems of all devices. `text` is the descriptor that
/// `cell` was read from.
Result<Deployed> deploy(Operator& asker, const model::Cell& cell, const std::string& text,
                        const DeployOptions& options);

/// The devices on which to end a deployment, and which deployment to end.
struct Devices {
  std::vector<std::string> names;
  std::map<std::string, std::int32_t> process_ids{};  ///< see DeployOptions
  std::string deployment{};                           ///< id of the deployment to end; empty for any
                                                      ///< deployment
};
/// Ends the deployment on all these devices in parallel. Waits until each device has answered or is lost.
/// Calls `meanwhile` repeatedly during this wait.
std::vector<Undeployed> undeploy(Operator& asker, const Devices& devices,
                                 const std::function<void()>& meanwhile = {});

/// The devices of a cell, as devices_of() finds them.
struct CellDevices {
  std::vector<std::string> names{};  ///< live devices that run the cell, or have run it and are not
                                     ///< undeployed
  std::vector<std::string> lost{};   ///< devices of the cell that other devices have lost
};
/// Finds the devices of a cell. Fails if no live device has the cell; the problem then lists the cells of the
/// domain.
Result<CellDevices> devices_of(Operator& asker, const std::string& cell);

}  // namespace takt::client
