// The state of the cell, collected from all topics: every device seen, alive or lost, and what it runs.
//
// Each topic reports one part, in its own order. The state of a module may arrive before its device's. A
// device that died reports nothing more. A waiting device changes its key when a cell is deployed to it.
// Observers want one cell state.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <takt/wire/takt.h>
#include <takt/wire/writer_id.hpp>

namespace takt::wire {

/// The last received state of a deployment on one device.
struct ObservedDeployment {
  std::map<std::string, LifecycleStatus> modules;  ///< by name, like all below
  std::map<std::string, ModuleStatistics> statistics;
  std::map<std::string, ExecutorStatistics> executors;
  std::map<std::string, PortStatus> ports;  ///< by MODULE.PORT
};

struct ObservedDevice {
  DeviceStatus status;
  bool alive = true;  ///< false: its node is lost, and this is the last received state
  ObservedDeployment deployment;

  [[nodiscard]] std::string name() const { return status.device().to_string(); }
  [[nodiscard]] std::string node() const { return status.node().to_string(); }
};

/// Feed it with what Readers receive, on one thread at a time. A node that ends cleanly disposes of its
/// samples and leaves the cell state. A node that dies stays in it as lost until another node of that name
/// appears.
class CellState {
 public:
  void heard(const DeviceStatus& status, WriterId writer);
  void heard(const LifecycleStatus& status);
  void heard(const ModuleStatistics& statistics);
  void heard(const ExecutorStatistics& statistics);
  void heard(const PortStatus& status);
  /// The sample holds only its key.
  void gone(const DeviceStatus& key, WriterId writer);
  void gone(const LifecycleStatus& key);
  /// The writer of a device's status was lost.
  void lost(WriterId writer);

  /// Whether the module is in EXECUTING and its device is alive. A device that was lost counts again from its
  /// second status on, because the new states of its modules arrive between the first and the second.
  [[nodiscard]] bool executes(const std::string& cell, const std::string& device,
                              const std::string& module) const;
  /// The last received status of the devices of a deployment, except `but`; includes lost devices.
  struct Heard {
    DeviceStatus status;
    bool alive = true;
  };
  [[nodiscard]] std::vector<Heard> of_deployment(const std::string& id, const std::string& but) const;

  /// Sorted by device, then by node. Two live entries with one name mean two nodes of the same name.
  [[nodiscard]] std::vector<ObservedDevice> devices() const;
  /// The devices of this name.
  [[nodiscard]] std::vector<ObservedDevice> devices(const std::string& name) const;

 private:
  struct Node {
    DeviceStatus status;
    WriterId writer = 0;
    bool alive = true;
    std::uint64_t back_at = 0;  // sequence of the first status after a loss; 0: never lost
  };
  [[nodiscard]] ObservedDevice seen(const Node& node) const;

  std::map<std::string, Node> nodes_;                      // by id
  std::map<std::string, ObservedDeployment> deployments_;  // by CELL/DEVICE
};

}  // namespace takt::wire
