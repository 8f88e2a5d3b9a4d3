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
  Problems problems{};                  ///< why it could not be undeployed; empty: it was undeployed
  nlohmann::ordered_json report{};      ///< its object of the status JSON; null: it sent none
  std::vector<std::string> failures{};  ///< why the device, or modules of it, failed
};

struct DeployOptions {
  /// How long to search for the devices.
  Nanoseconds discovery = std::chrono::seconds{5};
  /// T0 is this long after all devices are ready.
  Nanoseconds lead = std::chrono::milliseconds{1000};
  /// Each device must confirm T0 this long before it. If one does not, the deployment is undone on all
  /// devices in the time that remains.
  Nanoseconds margin = std::chrono::milliseconds{200};
  bool require_real_time = false;
  /// The process id of a device's node, where only that node will do (takt run started it).
  std::map<std::string, std::int32_t> process_ids;
  /// Called with one line for a person: what deploy() waits for.
  std::function<void(const std::string&)> progress;
  /// Polled until all is done; when it returns true, the deployment is undone.
  std::function<bool()> cancelled;
  /// Receives the answer of each device when a failed deployment was undone.
  std::vector<Undeployed>* undone = nullptr;
};

struct Deployed {
  std::string id;          ///< of the deployment
  std::int64_t t0_ns = 0;  ///< of the wall clock
};

/// Finds the devices, prepares all of them at the same time, and starts them all at one instant. Fails with
/// every reason of every device, after undoing the deployment. `text` is the descriptor that `cell` was read
/// from.
Result<Deployed> deploy(Operator& asker, const model::Cell& cell, const std::string& text,
                        const DeployOptions& options);

/// Which devices to undeploy, and which deployment.
struct Devices {
  std::vector<std::string> names;
  std::map<std::string, std::int32_t> process_ids{};  ///< as in DeployOptions
  std::string deployment{};                           ///< only this one; empty: any
};
/// Ends the deployment on these devices, on all at the same time, however long that takes. `meanwhile` is
/// called again and again while it waits.
std::vector<Undeployed> undeploy(Operator& asker, const Devices& devices,
                                 const std::function<void()>& meanwhile = {});

/// The devices of a cell.
struct CellDevices {
  std::vector<std::string> names{};  ///< devices that run the cell, or still hold it
  std::vector<std::string> lost{};   ///< devices that the others of the cell have lost
};
/// Fails if no device has the cell; the problem lists the cells that there are.
Result<CellDevices> devices_of(Operator& asker, const std::string& cell);

}  // namespace takt::client
