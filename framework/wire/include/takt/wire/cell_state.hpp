// Combines the samples of all topics into the state of the cell: every known device, alive or lost, and the
// modules that it runs.
//
// Each topic reports only a part of this state, and samples of different topics arrive in any order. A
// module's state may arrive before the status of its device. A device that died reports nothing more. A
// waiting device changes its key when a cell is deployed to it. This class handles these cases, so that
// observers get one consistent cell state.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <takt/wire/takt.h>
#include <takt/wire/writer_id.hpp>

namespace takt::wire {

/// The part of a deployment on one device, as last received.
struct ObservedDeployment {
  std::map<std::string, LifecycleStatus> modules;       ///< by module name
  std::map<std::string, ModuleStatistics> statistics;   ///< by module name
  std::map<std::string, ExecutorStatistics> executors;  ///< by executor name
  std::map<std::string, PortStatus> ports;              ///< by MODULE.PORT
};

struct ObservedDevice {
  DeviceStatus status;
  bool alive = true;  ///< false if its node is lost; then the rest is what was last received
  ObservedDeployment deployment;

  [[nodiscard]] std::string name() const { return status.device().to_string(); }
  [[nodiscard]] std::string node() const { return status.node().to_string(); }
};

/// Takes the samples from the DDS readers. Not thread-safe: only one thread at a time may call its functions.
/// A node that ends cleanly disposes of its samples and is removed. A node that dies stays in the cell state
/// as lost until another node of its device appears.
class CellState {
 public:
  void heard(const DeviceStatus& status, WriterId writer);
  void heard(const LifecycleStatus& status);
  void heard(const ModuleStatistics& statistics);
  void heard(const ExecutorStatistics& statistics);
  void heard(const PortStatus& status);
  /// Removes the device because its node disposed of the status. Only the key of the sample is set.
  void gone(const DeviceStatus& key, WriterId writer);
  void gone(const LifecycleStatus& key);
  /// Marks the device as lost, because DDS has lost the writer of its status.
  void lost(WriterId writer);

  /// Returns whether the module is in EXECUTING and its device is alive. A device that was lost counts as
  /// alive only when its second status after the loss has arrived, because the new states of its modules may
  /// arrive after the first.
  [[nodiscard]] bool executes(const std::string& cell, const std::string& device,
                              const std::string& module) const;
  /// A device as of_deployment() returns it.
  struct Heard {
    DeviceStatus status;
    bool alive = true;
  };
  /// Returns the last received status of each device of a deployment, also of lost devices, except the device
  /// `but`.
  [[nodiscard]] std::vector<Heard> of_deployment(const std::string& id, const std::string& but) const;

  /// Returns all devices, sorted by device name, then by node. Two live entries with the same name mean that
  /// two nodes use this device name.
  [[nodiscard]] std::vector<ObservedDevice> devices() const;
  /// Returns all entries with this device name: more than one if several nodes use the name.
  [[nodiscard]] std::vector<ObservedDevice> devices(const std::string& name) const;

 private:
  struct Node {
    DeviceStatus status;
    WriterId writer = 0;
    bool alive = true;
    std::uint64_t back_at = 0;  // sequence number of the first status after a loss; 0 if never lost
  };
  [[nodiscard]] ObservedDevice seen(const Node& node) const;

  std::map<std::string, Node> nodes_;                      // by id
  std::map<std::string, ObservedDeployment> deployments_;  // by CELL/DEVICE
};

}  // namespace takt::wire
