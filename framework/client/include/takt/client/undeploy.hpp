// Finds the devices of a deployed cell, and ends the deployment.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include <takt/client/operator.hpp>
#include <takt/core/result.hpp>

namespace takt::client {

/// The answer of one device to the command to end its deployment.
struct Undeployed {
  std::string device;
  Problems problems{};                  ///< the reasons why the deployment could not be ended; empty if it
                                        ///< has ended
  nlohmann::ordered_json report{};      ///< the device's last status as JSON; null if the device sent
                                        ///< none
  std::vector<std::string> failures{};  ///< the reasons why the device or its modules failed
};

/// The devices on which to end a deployment, and which deployment to end.
struct Devices {
  std::vector<std::string> names;
  std::map<std::string, std::int32_t> process_ids{};  ///< see DeployOptions
  std::string deployment{};                           ///< id of the deployment to end; empty: any
                                                      ///< deployment
};
/// Ends the deployment on all these devices in parallel. Waits until each device has answered or is lost, and
/// calls `meanwhile` repeatedly during this wait. Returns one entry for each device.
std::vector<Undeployed> undeploy(Operator& sender, const Devices& devices,
                                 const std::function<void()>& meanwhile = {});

/// The devices of a deployed cell.
struct CellDevices {
  std::string deployment{};            ///< id of the deployment
  std::vector<std::string> names{};    ///< live devices that have the deployment, even if it has ended there
  std::vector<std::string> waiting{};  ///< live devices of the cell that have no deployment
  std::vector<std::string> lost{};     ///< devices of the cell that this program does not reach
};
/// Finds the devices of a cell. `cell` is its name or the id of its deployment. Fails if no device has it, or
/// if several deployments have this name.
Result<CellDevices> devices_of(Operator& sender, const std::string& cell);

/// Parts of devices_of() that need no network.
/// Returns the live devices of each deployment of the cell, by the id of the deployment.
std::map<std::string, std::vector<std::string>> deployments_of(const std::vector<wire::ObservedDevice>& seen,
                                                               const std::string& cell);
/// Sorts all devices of a cell. A device with another deployment has left the cell, and is not in the result.
CellDevices sort_devices(const std::vector<wire::ObservedDevice>& seen, const std::string& deployment,
                         const std::set<std::string>& whole);

}  // namespace takt::client
