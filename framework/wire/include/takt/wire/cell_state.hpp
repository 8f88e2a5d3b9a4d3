// The state of the cell, collected from all topics: every device that was seen, alive or lost, and what it
// runs.
//
// Each topic reports only a part of this state, and the topics have no common order. The state of a module
// may arrive before its device's. A device that died reports nothing more. A waiting device changes its key
// when a cell is deployed to it. This class combines all that, so that observers get one cell state.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <takt/wire/takt.h>
#include <takt/wire/writer_id.hpp>

namespace takt::wire {

/// The last received state of a deployment on one device.
struct ObservedDeployment {
  std::map<std::string, LifecycleStatus> modules;  ///< by name, like the members below
  std::map<std::string, ModuleStatistics> statistics;
  std::map<std::string, ExecutorStatistics> executors;
  std::map<std::string, PortStatus> ports;  ///< by MODULE.PORT
};

struct ObservedDevice {
  DeviceStatus status;
  bool alive = true;  ///< false if its node is lost; then this is the last received state
  ObservedDeployment deployment;

  [[nodiscard]] std::string name() const { return status.device().to_string(); }
  [[nodiscard]] std::string node() const { return status.node().to_string(); }
};

/// Collects what Readers receive. One thread at a time may call it. A node that ends cleanly disposes of its
/// samples and is removed. A node that dies stays in the cell state as lost until another node of its device
/// appears.
class CellState {
 public:
  void heard(const DeviceStatus& status, WriterId writer);
  void heard(const LifecycleStatus& status);
  void heard(const ModuleStatistics& statistics);
  void heard(const ExecutorStatistics& statistics);
  void heard(const PortStatus& status);
  /// The status of a device was disposed of. Only the key of the sample is set.
  void gone(const DeviceStatus& key, WriterId writer);
  void gone(const LifecycleStatus& key);
  /// The writer of a device's status was lost.
  void lost(WriterId writer);

  /// Whether the module is in EXECUTING and its device is alive. A device that was lost counts as alive from
  /// its second new status on, because the new states of its modules arrive between the first and the second
  /// status.
  [[nodiscard]] bool executes(const std::string& cell, const std::string& device,
                              const std::string& module) const;
  /// The last received status of each device of a deployment, except the device `but`. Includes lost devices.
  struct Heard {
    DeviceStatus status;
    bool alive = true;
  };
  [[nodiscard]] std::vector<Heard> of_deployment(const std::string& id, const std::string& but) const;

  /// All devices, sorted by device name, then by node. Two live entries with the same name mean that two
  /// nodes use this name.
  [[nodiscard]] std::vector<ObservedDevice> devices() const;
  /// All devices of this name.
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
