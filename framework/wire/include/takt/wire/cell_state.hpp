// Combines the samples of all topics into the state of the cell: every known device, alive or lost, and the
// modules that the device runs.
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
#include <takt/wire/judgement.hpp>
#include <takt/wire/writer_id.hpp>

namespace takt::wire {

/// A port, with what its statuses say together.
struct ObservedPort {
  PortStatus status;
  RisingCount lost{};
  RisingCount dropped{};

  [[nodiscard]] bool losing() const noexcept { return lost.rises(Nanoseconds{status.time_ns()}); }
  [[nodiscard]] bool dropping() const noexcept { return dropped.rises(Nanoseconds{status.time_ns()}); }
};

/// The part of a deployment on one device, as last received.
struct ObservedDeployment {
  std::map<std::string, LifecycleStatus> modules;       ///< by module name
  std::map<std::string, ModuleStatistics> statistics;   ///< by module name
  std::map<std::string, ExecutorStatistics> executors;  ///< by executor name
  std::map<std::string, ObservedPort> ports;            ///< by MODULE.PORT
};

/// True if the module is in START until an operator starts it: an operator stopped it, or it has recovered
/// from an error while it was stopped.
bool is_stopped(const LifecycleStatus& module) noexcept;
/// True if the module is in START and waits for its first release since a start.
bool awaits_release(const LifecycleStatus& module) noexcept;

struct ObservedDevice {
  DeviceStatus status;
  bool alive = true;  ///< false if the node is lost; then the other members are the last received values
  ObservedDeployment deployment;

  [[nodiscard]] std::string name() const { return status.device().to_string(); }
  [[nodiscard]] std::string node() const { return status.node().to_string(); }
};

/// Takes the samples from the DDS readers. Not thread-safe: only one thread at a time may call its functions.
/// A node that ends cleanly disposes of its samples and is removed. A node that dies stays in the cell state
/// as lost until another node of its device appears.
class CellState {
 public:
  void receive(const DeviceStatus& status, WriterId writer);
  void receive(const LifecycleStatus& status);
  void receive(const ModuleStatistics& statistics);
  void receive(const ExecutorStatistics& statistics);
  void receive(const PortStatus& status);
  /// Removes the device, because its node has disposed of the status. In `key`, only the key of the sample is
  /// set.
  void remove(const DeviceStatus& key, WriterId writer);
  void remove(const LifecycleStatus& key);
  /// Marks the device as lost, because DDS has lost the writer of the device's status.
  void lost(WriterId writer);

  /// Returns true if the module is in EXECUTING and its device is alive. A device that was lost counts as
  /// alive only when its second status after the loss has arrived, because the new states of its modules may
  /// arrive after the first status.
  [[nodiscard]] bool executes(const std::string& cell, const std::string& device,
                              const std::string& module) const;
  /// Returns true if the device is known, and each node with its name is lost.
  [[nodiscard]] bool has_lost(const std::string& device) const;
  /// The last received status of a node, until this cell state changes. A status is long, and a node looks at
  /// those of all others in each step.
  struct LastStatus {
    const DeviceStatus& status;
    bool alive;
  };
  /// Returns the last received status of each device whose newest deployment is `id`, except the device
  /// `but`. The result includes lost devices, and devices that have undone the deployment.
  [[nodiscard]] std::vector<LastStatus> of_deployment(const std::string& id, const std::string& but) const;
  /// Returns the last received status of each node with this device name, also of lost nodes.
  [[nodiscard]] std::vector<LastStatus> of_device(const std::string& name) const;

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

  std::map<std::string, Node> nodes_;                      // by the id of the node
  std::map<std::string, ObservedDeployment> deployments_;  // by CELL/DEVICE
};

}  // namespace takt::wire
