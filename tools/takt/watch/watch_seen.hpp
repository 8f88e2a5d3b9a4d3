// Makes the snapshots that `takt watch` draws, from the samples that the nodes of a DDS domain publish.
#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <takt/client/history.hpp>
#include <takt/core/time.hpp>
#include <takt/model/cell.hpp>
#include <takt/model/fault.hpp>
#include <takt/wire/cell_state.hpp>

#include "watch/seen.hpp"

namespace takt::tool {

/// Makes snapshots, and keeps the earlier data that they need: transitions, events and descriptors. Only one
/// thread may use an object of this class.
class Watched {
 public:
  explicit Watched(int domain) : domain_(domain) {}

  /// Adds a state transition of a module. Call this once for each transition, in order.
  void add(const LifecycleStatus& status);
  /// Adds a line to the list of events.
  void add(const std::string& event);
  /// Adds an event of a fault record. Notes are left out.
  void add(const model::Fault& fault);
  /// Sets the cell of a deployment. If `cell` is null, because the node did not send its descriptor, nothing
  /// changes.
  void add(const std::string& deployment, std::shared_ptr<const model::Cell> cell);

  /// A device whose descriptor is not known, and the name of its deployment.
  struct Unknown {
    std::string device;
    std::string deployment;
  };
  /// Returns the next device to ask for its descriptor, and notes that the device is being asked. None if no
  /// device needs to be asked now.
  std::optional<Unknown> unknown(const std::vector<wire::ObservedDevice>& devices, Instant now);

  /// Returns the next device to ask for its report, and notes that the device is being asked. None if no
  /// device needs to be asked now.
  std::optional<std::string> unreported(const std::vector<wire::ObservedDevice>& devices, Instant now);
  /// Sets the components of a device: by module, the file, version and hash.
  void add_components(const std::string& device, std::map<std::string, std::string> components);

  /// The current state of the domain. If a device of the cell is not found within kFound, the snapshot shows
  /// the device as lost, because it must have been lost before `takt watch` started.
  watch::Snapshot snapshot(const std::vector<wire::ObservedDevice>& devices, Instant now);
  static constexpr std::chrono::seconds kFound{2};

 private:
  struct Known;
  static void add_missed(watch::Snapshot& snapshot, Known& known,
                         const std::vector<wire::ObservedDevice>& devices, Instant now);

  int domain_;
  client::History history_;
  std::map<std::string, std::vector<watch::Transition>> transitions_;  // for each module, by DEVICE.MODULE
  std::deque<std::string> events_;
  std::deque<watch::Fault> faults_;  // by time
  struct Known {
    std::shared_ptr<const model::Cell> cell;
    Instant asked{};
    std::map<std::string, Instant>
        missed{};  ///< the devices of the cell that are not found, each with the time of the first search
  };
  std::map<std::string, Known> cells_;  // for each deployment, by its name
  struct Reported {
    std::string deployment;
    Instant asked{};
    std::map<std::string, std::string> components{};
  };
  std::map<std::string, Reported> reports_;  // for each device, by its name
};

}  // namespace takt::tool
