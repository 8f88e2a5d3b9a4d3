// What the topics tell, put together: every device that was heard of, alive or lost, and what is on it.
//
// Each topic tells a part, in an order of its own: the state of a module may come before the device that it
// is on, a device that died tells nothing any more, and one that waits changes its key when it is deployed
// to. Whoever looks on wants one cell state.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <takt/wire/takt.h>
#include <takt/dds/topics.hpp>

namespace takt::dds {

/// What was last heard of a deployment on one device.
struct ObservedDeployment {
  std::map<std::string, LifecycleStatus> modules;  ///< by name, as all below
  std::map<std::string, ModuleStatistics> statistics;
  std::map<std::string, ExecutorStatistics> executors;
  std::map<std::string, PortStatus> ports;  ///< by MODULE.PORT
};

struct ObservedDevice {
  DeviceStatus status;
  bool alive = true;  ///< false: its node is lost, and all of this is the last that was heard
  ObservedDeployment deployment;

  [[nodiscard]] std::string name() const { return status.device().to_string(); }
  [[nodiscard]] std::string node() const { return status.node().to_string(); }
};

/// Fed by what a Reader hears; one thread at a time. A node that ends in order disposes of what it said and
/// is no part of the cell state any more; one that dies stays as lost until another node of that name comes.
class CellState {
 public:
  void heard(const DeviceStatus& status, WriterId writer);
  void heard(const LifecycleStatus& status);
  void heard(const ModuleStatistics& statistics);
  void heard(const ExecutorStatistics& statistics);
  void heard(const PortStatus& status);
  /// The sample holds nothing but its key.
  void gone(const DeviceStatus& key, WriterId writer);
  void gone(const LifecycleStatus& key);
  /// The writer of a device's status.
  void lost(WriterId writer);

  /// The module is in EXECUTING, and its device is alive. One that was lost is so again from the second
  /// status on that comes after: what became of its modules meanwhile comes between the two.
  [[nodiscard]] bool executes(const std::string& cell, const std::string& device,
                              const std::string& module) const;
  /// What was last heard of the devices of a deployment that are not `but`; those that are lost too.
  struct Heard {
    DeviceStatus status;
    bool alive = true;
  };
  [[nodiscard]] std::vector<Heard> of_deployment(const std::string& id, const std::string& but) const;

  /// By device, then by node. Two that are alive under one name are two nodes of one name.
  [[nodiscard]] std::vector<ObservedDevice> devices() const;
  /// The same of one name.
  [[nodiscard]] std::vector<ObservedDevice> devices(const std::string& name) const;

 private:
  struct Node {
    DeviceStatus status;
    WriterId writer = 0;
    bool alive = true;
    std::uint64_t back_at = 0;  // the first status since it was lost; 0: it never was
  };
  [[nodiscard]] ObservedDevice seen(const Node& node) const;

  std::map<std::string, Node> nodes_;                      // by its id
  std::map<std::string, ObservedDeployment> deployments_;  // by CELL/DEVICE
};

}  // namespace takt::dds
