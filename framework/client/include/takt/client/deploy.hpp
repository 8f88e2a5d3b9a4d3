// A cell onto its devices: on all of them or on none.
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

/// What one device said when it had ended.
struct Undeployed {
  std::string device;
  Problems problems{};                  ///< why it could not be undeployed; empty: it was
  nlohmann::ordered_json report{};      ///< its object of the status JSON; null where it gave none
  std::vector<std::string> failures{};  ///< why it, or modules of it, had failed
};

struct DeployOptions {
  /// For all devices to be found.
  Nanoseconds discovery = std::chrono::seconds{5};
  /// From the moment on that all are ready to T0, and how long before T0 each must have said that it will
  /// run: what is left is for taking it back everywhere when one did not.
  Nanoseconds lead = std::chrono::milliseconds{1000};
  Nanoseconds margin = std::chrono::milliseconds{200};
  bool require_real_time = false;
  /// Where only certain nodes are meant (takt run started them): the process id of each device's.
  std::map<std::string, std::int32_t> process_ids;
  /// One line for a person: what is being waited for.
  std::function<void(const std::string&)> progress;
  /// Whether it is to be given up; all is undone then. Asked all the time.
  std::function<bool()> cancelled;
  /// Gets what each device said when it was undone, after a failure.
  std::vector<Undeployed>* undone = nullptr;
};

struct Deployed {
  std::string id;          ///< of the deployment
  std::int64_t t0_ns = 0;  ///< of the wall clock
};

/// Finds the devices, has each of them prepared at once, and lets all run from one instant. Fails with every
/// reason of every device; nothing is left of it then. `text` is the descriptor that `cell` was read from.
Result<Deployed> deploy(Operator& asker, const model::Cell& cell, const std::string& text,
                        const DeployOptions& options);

/// Which devices, and whose.
struct Devices {
  std::vector<std::string> names;
  std::map<std::string, std::int32_t> process_ids{};  ///< as when it was deployed
  std::string deployment{};                           ///< only this one; empty: whichever there is
};
/// Ends it on these devices, all at once, however long that takes. `meanwhile` is called all the time.
std::vector<Undeployed> undeploy(Operator& asker, const Devices& devices,
                                 const std::function<void()>& meanwhile = {});

/// Where a cell is.
struct CellDevices {
  std::vector<std::string> names{};  ///< on which it runs, or is otherwise held
  std::vector<std::string> lost{};   ///< of which the others say that they do not hear them any more
};
/// Fails where no device has the cell, and says which cells there are.
Result<CellDevices> devices_of(Operator& asker, const std::string& cell);

}  // namespace takt::client
